// From OpenVDB's trees to plain arrays.

#include "fogbow/cpp/vdb_voxels.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetUtil.h>

#include <array>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "fogbow/src/vdb/ffi.rs.h"

namespace fogbow {

struct Voxels::Data {
    openvdb::GridBase::Ptr grid;
    size_t components = 1;
    std::array<float, 3> background{};
    uint64_t active_voxels = 0;
    std::vector<int32_t> origins;
    std::vector<float> values;
    std::vector<uint64_t> masks;
    std::vector<Tile> tiles;
};

namespace {

using Scalars = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid,
                                  openvdb::Int64Grid, openvdb::BoolGrid>;
using Vectors = openvdb::TypeList<openvdb::Vec3SGrid, openvdb::Vec3DGrid, openvdb::Vec3IGrid>;
using Known = Scalars::Append<Vectors>;

template <typename T>
constexpr size_t kComponents = openvdb::VecTraits<T>::IsVec ? 3 : 1;

template <typename T>
std::array<float, 3> numbers(const T& value) {
    if constexpr (openvdb::VecTraits<T>::IsVec) {
        return {static_cast<float>(value[0]), static_cast<float>(value[1]),
                static_cast<float>(value[2])};
    } else {
        return {static_cast<float>(value), 0.0f, 0.0f};
    }
}

template <typename Leaf>
void copy_leaf(const Leaf& leaf, Voxels::Data& data) {
    const openvdb::Coord origin = leaf.origin();
    data.origins.insert(data.origins.end(), {origin.x(), origin.y(), origin.z()});
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
        const auto value = numbers(leaf.getValue(i));
        data.values.insert(data.values.end(), value.begin(), value.begin() + data.components);
    }
    for (openvdb::Index i = 0; i < Leaf::SIZE / 64; ++i) {
        data.masks.push_back(leaf.valueMask().template getWord<openvdb::Index64>(i));
    }
}

template <typename Tree>
void copy_tiles(const Tree& tree, Voxels::Data& data) {
    auto tile = tree.cbeginValueAll();
    tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) {
        if (!tile.isValueOn() && tile.getValue() == tree.background()) continue;
        const auto box = tile.getBoundingBox();
        uint32_t log2_size = 0;
        while ((int64_t{1} << log2_size) < int64_t{box.max().x()} - box.min().x() + 1) ++log2_size;
        const openvdb::Coord origin = box.min();
        data.tiles.push_back({{origin.x(), origin.y(), origin.z()},
                              log2_size,
                              numbers(tile.getValue()),
                              tile.isValueOn()});
    }
}

template <typename Grid>
void copy_grid(const Grid& grid, Voxels::Data& data) {
    const auto& tree = grid.tree();
    data.components = kComponents<typename Grid::ValueType>;
    data.background = numbers(tree.background());
    data.active_voxels = tree.activeVoxelCount();
    const size_t leaves = tree.leafCount();
    data.origins.reserve(leaves * 3);
    data.values.reserve(leaves * 512 * data.components);
    data.masks.reserve(leaves * 8);
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) copy_leaf(*leaf, data);
    copy_tiles(tree, data);
}

// Half floats, which OpenVDB 13 keeps in memory as such, as floats; any other grid as it is.
openvdb::GridBase::Ptr widened(openvdb::GridBase::Ptr grid) {
#if OPENVDB_LIBRARY_MAJOR_VERSION_NUMBER >= 13
    if (const auto halves = openvdb::GridBase::grid<openvdb::HalfGrid>(grid)) {
        auto tree = std::make_shared<openvdb::FloatTree>(halves->constTree());
        auto floats = openvdb::FloatGrid::create(tree);
        floats->setGridClass(halves->getGridClass());
        return floats;
    }
#endif
    return grid;
}

}  // namespace

std::unique_ptr<Voxels> extract(openvdb::GridBase::Ptr grid, bool fog) {
    grid = widened(std::move(grid));
    if (fog) {
        const bool converted =
            grid->apply<openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid>>(
                [](auto& level_set) { openvdb::tools::sdfToFogVolume(level_set); });
        if (!converted) throw std::runtime_error("only level sets of floats can become fog");
    }
    auto data = std::make_unique<Voxels::Data>();
    data->grid = grid;
    const bool known =
        std::as_const(*grid).apply<Known>([&](const auto& typed) { copy_grid(typed, *data); });
    if (!known) throw std::runtime_error("its type " + grid->type() + " holds no numbers");
    return std::make_unique<Voxels>(std::move(data));
}

Voxels::Voxels(std::unique_ptr<Data> data) : data_(std::move(data)) {}
Voxels::~Voxels() = default;

size_t Voxels::components() const { return data_->components; }
std::array<float, 3> Voxels::background() const { return data_->background; }
uint64_t Voxels::active_voxels() const { return data_->active_voxels; }
rust::Slice<const int32_t> Voxels::origins() const {
    return {data_->origins.data(), data_->origins.size()};
}
rust::Slice<const float> Voxels::values() const {
    return {data_->values.data(), data_->values.size()};
}
rust::Slice<const uint64_t> Voxels::masks() const {
    return {data_->masks.data(), data_->masks.size()};
}

rust::Vec<Tile> Voxels::tiles() const {
    rust::Vec<Tile> tiles;
    tiles.reserve(data_->tiles.size());
    for (const auto& tile : data_->tiles) tiles.push_back(tile);
    return tiles;
}

void Voxels::box_sample(rust::Slice<const double> points, rust::Slice<double> out) const {
    const size_t n = data_->components;
    if (points.size() / 3 * n != out.size()) throw std::runtime_error("sizes do not match");
    std::as_const(*data_->grid).apply<Known>([&](const auto& grid) {
        auto accessor = grid.getConstAccessor();
        for (size_t i = 0; i < points.size() / 3; ++i) {
            const openvdb::Vec3d point(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
            const auto value = openvdb::tools::BoxSampler::sample(accessor, point);
            if constexpr (openvdb::VecTraits<std::decay_t<decltype(value)>>::IsVec) {
                for (int c = 0; c < 3; ++c) out[3 * i + c] = static_cast<double>(value[c]);
            } else {
                out[i] = static_cast<double>(value);
            }
        }
    });
}

}  // namespace fogbow
