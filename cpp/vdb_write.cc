// Writing, for procedural content and for tests.

#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>

#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>

#include "fogbow/cpp/vdb.h"
#include "fogbow/src/vdb/ffi.rs.h"

namespace fogbow {

namespace {

template <typename T>
T value_from(const float* numbers) {
    if constexpr (openvdb::VecTraits<T>::IsVec) {
        return T(numbers[0], numbers[1], numbers[2]);
    } else {
        return static_cast<T>(numbers[0]);
    }
}

openvdb::Coord coord(const int32_t* xyz) { return {xyz[0], xyz[1], xyz[2]}; }

openvdb::math::Transform::Ptr transform_of(const WriteGrid& grid) {
    using openvdb::math::Transform;
    if (grid.frustum) {
        const openvdb::BBoxd box(openvdb::Vec3d(0), openvdb::Vec3d(100));
        return Transform::createFrustumTransform(box, 0.5, 10.0);
    }
    openvdb::Mat4d matrix;
    for (int i = 0; i < 16; ++i) matrix.asPointer()[i] = grid.affine[i];
    return Transform::createLinearTransform(matrix);
}

template <typename Grid>
openvdb::GridBase::Ptr make(const WriteGrid& source) {
    using Value = typename Grid::ValueType;
    using Leaf = typename Grid::TreeType::LeafNodeType;
    const size_t components = openvdb::VecTraits<Value>::IsVec ? 3 : 1;
    const size_t leaves = source.origins.size() / 3;
    if (source.values.size() != leaves * Leaf::SIZE * components ||
        source.masks.size() != leaves * Leaf::SIZE / 64) {
        throw std::runtime_error("a leaf needs 512 values and 8 mask words");
    }
    auto grid = Grid::create(value_from<Value>(source.background.data()));
    auto& tree = grid->tree();
    for (const auto& tile : source.tiles) {
        // A tile of 8, 128 or 4096 voxels an edge lives at level 1, 2 or 3.
        const openvdb::Index level = tile.log2_size == 3 ? 1 : tile.log2_size == 7 ? 2 : 3;
        tree.addTile(level, coord(tile.origin.data()), value_from<Value>(tile.value.data()),
                     tile.active);
    }
    for (size_t i = 0; i < leaves; ++i) {
        auto leaf = std::make_unique<Leaf>(coord(&source.origins[3 * i]));
        for (openvdb::Index v = 0; v < Leaf::SIZE; ++v) {
            const float* numbers = &source.values[(i * Leaf::SIZE + v) * components];
            const bool active = source.masks[i * 8 + v / 64] >> (v % 64) & 1;
            leaf->setValueOnly(v, value_from<Value>(numbers));
            leaf->setActiveState(v, active);
        }
        tree.addLeaf(leaf.release());
    }
    return grid;
}

openvdb::GridBase::Ptr make_any(const WriteGrid& source) {
    const std::string type(source.value_type);
    if (type == "float") return make<openvdb::FloatGrid>(source);
    if (type == "double") return make<openvdb::DoubleGrid>(source);
    if (type == "int32") return make<openvdb::Int32Grid>(source);
    if (type == "int64") return make<openvdb::Int64Grid>(source);
    if (type == "bool") return make<openvdb::BoolGrid>(source);
    if (type == "vec3s") return make<openvdb::Vec3SGrid>(source);
    throw std::runtime_error("no grids of type " + type + " are written");
}

// What openvdb::io::File writes, to a stream of ours: File itself does not notice a full disk.
struct Writer : openvdb::io::Archive {
    void write(std::ostream& out, const openvdb::GridPtrVec& grids) const {
        Archive::write(out, grids, /*seekable=*/true);
    }
};

}  // namespace

void write_file(rust::Str path, rust::Slice<const WriteGrid> grids) {
    openvdb::initialize();
    openvdb::GridPtrVec all;
    for (const auto& source : grids) {
        auto grid = make_any(source);
        grid->setName(std::string(source.name));
        grid->setGridClass(openvdb::GridBase::stringToGridClass(std::string(source.grid_class)));
        grid->setSaveFloatAsHalf(source.half);
        grid->setTransform(transform_of(source));
        all.push_back(grid);
    }
    std::ofstream out(std::string(path), std::ios::binary | std::ios::trunc);
    Writer().write(out, all);
    out.close();
    if (!out) throw std::runtime_error("not all of it can be stored; is the disk full?");
}

}  // namespace fogbow
