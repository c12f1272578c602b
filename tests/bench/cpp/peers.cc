// GCC cannot see that NanoVDB's sampler is filled before it is read.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#define NDEBUG  // no assertions in what is timed

#include "fogbow/tests/bench/cpp/peers.h"

#include <nanovdb/util/OpenToNanoVDB.h>
#include <nanovdb/util/SampleFromVoxels.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>

#include <stdexcept>
#include <string>
#include <utility>

#include "fogbow/tests/bench/peers.rs.h"

namespace fogbow {

struct Peers::Data {
    openvdb::FloatGrid::Ptr grid;
    nanovdb::GridHandle<nanovdb::HostBuffer> handle;
};

namespace {

template <typename Vec, typename Sample>
double sum(rust::Slice<const Run> runs, double step, const Sample& sample) {
    using Real = typename Vec::ValueType;
    double sum = 0.0;
    for (const Run& run : runs) {
        const Vec origin(run.origin[0], run.origin[1], run.origin[2]);
        const Vec direction(run.direction[0], run.direction[1], run.direction[2]);
        for (uint32_t k = 0; k < run.count; ++k) {
            const Real t = static_cast<Real>(run.first + k * step);
            sum += static_cast<double>(sample(origin + direction * t));
        }
    }
    return sum;
}

template <typename Vec>
double nanovdb_sum(const Peers::Data& data, rust::Slice<const Run> runs, double step) {
    const auto accessor = data.handle.grid<float>()->getAccessor();
    const nanovdb::SampleFromVoxels<std::decay_t<decltype(accessor)>, 1> sampler(accessor);
    return sum<Vec>(runs, step, [&](const Vec& p) { return sampler(p); });
}

}  // namespace

Peers::Peers(std::unique_ptr<Data> data) : data_(std::move(data)) {}
Peers::~Peers() = default;

double Peers::openvdb(rust::Slice<const Run> runs, double step) const {
    const auto accessor = data_->grid->getConstAccessor();
    return sum<openvdb::Vec3d>(runs, step, [&](const openvdb::Vec3d& p) {
        return openvdb::tools::BoxSampler::sample(accessor, p);
    });
}

double Peers::nanovdb_f64(rust::Slice<const Run> runs, double step) const {
    return nanovdb_sum<nanovdb::Vec3d>(*data_, runs, step);
}

double Peers::nanovdb_f32(rust::Slice<const Run> runs, double step) const {
    return nanovdb_sum<nanovdb::Vec3f>(*data_, runs, step);
}

std::unique_ptr<Peers> open_peers(rust::Str path, rust::Str grid) {
    openvdb::initialize();
    openvdb::io::File file{std::string(path)};
    file.open(/*delayLoad=*/false);
    auto data = std::make_unique<Peers::Data>();
    data->grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid(std::string(grid)));
    if (!data->grid) throw std::runtime_error("the grid is not one of floats");
    data->handle = nanovdb::openToNanoVDB(*data->grid);
    return std::make_unique<Peers>(std::move(data));
}

}  // namespace fogbow
