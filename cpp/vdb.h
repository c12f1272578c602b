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
struct GridPlace;
struct MetadataText;
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

// An open file, from which metadata and voxels are read where the caller says they are.
class File {
   public:
    class Stream;
    explicit File(std::unique_ptr<Stream> stream);
    ~File();

    rust::Vec<MetadataText> metadata(uint64_t at) const;
    GridHeader header(const GridPlace& place) const;
    std::unique_ptr<Voxels> read(const GridPlace& place, bool fog) const;

   private:
    std::unique_ptr<Stream> stream_;
};

void map_large_blocks();
rust::String library_version();
uint32_t newest_file_version();
std::unique_ptr<File> open_file(rust::Str path, std::array<uint32_t, 2> library, uint32_t format);
void write_file(rust::Str path, rust::Slice<const WriteGrid> grids);

}  // namespace fogbow
