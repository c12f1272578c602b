// The bridge between fogbow's Rust and OpenVDB. OpenVDB's own headers stay in the .cc files, so
// that the generated glue compiles without them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "rust/cxx.h"

namespace fogbow {

struct GridHeader;
struct Tile;
struct WriteGrid;

// One grid, read and turned into plain arrays; the grid itself is kept for box_sample.
class Voxels {
   public:
    struct Data;
    explicit Voxels(std::unique_ptr<Data> data);
    ~Voxels();

    size_t components() const;
    std::array<float, 3> background() const;
    uint64_t active_voxels() const;
    rust::Slice<const int32_t> origins() const;
    rust::Slice<const float> values() const;
    rust::Slice<const uint64_t> masks() const;
    rust::Vec<Tile> tiles() const;
    void box_sample(rust::Slice<const double> points, rust::Slice<double> out) const;

   private:
    std::unique_ptr<Data> data_;
};

// An open file: the metadata of all its grids, and the voxels of those asked for.
class File {
   public:
    class Reader;
    explicit File(std::unique_ptr<Reader> reader);
    ~File();

    rust::String library_of_writer() const;
    rust::Vec<GridHeader> headers() const;
    std::unique_ptr<Voxels> read(size_t index, bool fog) const;

   private:
    std::unique_ptr<Reader> reader_;
};

void map_large_blocks();
rust::String library_version();
uint32_t newest_file_version();
std::unique_ptr<File> open_file(rust::Str path);
void write_file(rust::Str path, rust::Slice<const WriteGrid> grids);

}  // namespace fogbow
