// How the C library's allocator deals with large blocks, OpenVDB's and Rust's alike.
#include "fogbow/cpp/vdb.h"

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace fogbow {

void map_large_blocks() {
#if defined(__GLIBC__)
    constexpr int large = 1 << 20;
    mallopt(M_MMAP_THRESHOLD, large);
#endif
}

}  // namespace fogbow
