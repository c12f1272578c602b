// OpenVDB's and NanoVDB's own samplers, looped over runs of points along rays.
#pragma once

#include <memory>

#include "rust/cxx.h"

namespace fogbow {

struct Run;

// One float grid, held by both libraries.
class Peers {
   public:
    struct Data;
    explicit Peers(std::unique_ptr<Data> data);
    ~Peers();

    // Each returns the sum of the trilinear values at all points of the runs, `step` apart.
    double openvdb(rust::Slice<const Run> runs, double step) const;
    double nanovdb_f64(rust::Slice<const Run> runs, double step) const;
    double nanovdb_f32(rust::Slice<const Run> runs, double step) const;

   private:
    std::unique_ptr<Data> data_;
};

std::unique_ptr<Peers> open_peers(rust::Str path, rust::Str grid);

}  // namespace fogbow
