// Reading: metadata at once, voxels grid by grid.
//
// Where things stand in the file is known from src/vdb/check, so that only what decodes metadata,
// transforms and trees is asked of OpenVDB: openvdb::io::Archive changes its calls from version to
// version and warns on stderr of formats newer than its own.

#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "fogbow/cpp/vdb_voxels.h"
#include "fogbow/src/vdb/ffi.rs.h"

namespace fogbow {

namespace {

// Bounds of the metadata that is handed over as text.
constexpr size_t kMostTexts = 256;
constexpr size_t kLongestText = 256;

// The matrix of a linear transform; zeros where it is singular, which OpenVDB throws at.
openvdb::Mat4d matrix_of(const openvdb::math::Transform& transform) {
    try {
        return transform.baseMap()->getAffineMap()->getMat4();
    } catch (const openvdb::ArithmeticError&) {
        return openvdb::Mat4d::zero();
    }
}

rust::Vec<MetadataText> texts_of(const openvdb::MetaMap& metadata) {
    rust::Vec<MetadataText> texts;
    for (auto entry = metadata.beginMeta(); entry != metadata.endMeta(); ++entry) {
        const auto& [name, value] = *entry;
        if (!openvdb::Metadata::isRegisteredType(value->typeName())) continue;
        if (name == openvdb::GridBase::META_FILE_DELAYED_LOAD) continue;
        if (name.size() > kLongestText || value->size() > kLongestText) continue;
        const std::string text = value->str();
        if (text.size() > kLongestText) continue;
        texts.push_back({rust::String::lossy(name), rust::String::lossy(text)});
        if (texts.size() == kMostTexts) break;
    }
    return texts;
}

}  // namespace

// openvdb::io::File ignores the state of its stream, so a truncated file would be read as garbage.
// This stream throws.
class File::Stream {
   public:
    Stream(const std::string& path, const openvdb::VersionId& library, uint32_t format) {
        stream_.exceptions(std::ios::failbit | std::ios::badbit);
        stream_.open(path, std::ios::binary);
        openvdb::io::setStreamMetadataPtr(stream_, metadata_, /*transfer=*/false);
        openvdb::io::setVersion(stream_, library, std::min(format, openvdb::OPENVDB_FILE_VERSION));
    }

    openvdb::MetaMap metadata(uint64_t at) {
        seek(at);
        openvdb::MetaMap metadata;
        metadata.readMeta(stream_);
        return metadata;
    }

    // A grid with its metadata and transform, and its flags of compression; the stream goes on with
    // its tree.
    std::pair<openvdb::GridBase::Ptr, uint32_t> open(const GridPlace& place) {
        auto grid = openvdb::GridBase::createGrid(std::string(place.tree_type));
        seek(place.start);
        uint32_t compression = 0;
        stream_.read(reinterpret_cast<char*>(&compression), sizeof compression);
        openvdb::io::setDataCompression(stream_, compression);
        openvdb::io::setGridBackgroundValuePtr(stream_, nullptr);
        grid->readMeta(stream_);
        openvdb::io::setGridClass(stream_, grid->getGridClass());
        openvdb::io::setHalfFloat(stream_, grid->saveFloatAsHalf());
        grid->readTransform(stream_);
        return {grid, compression};
    }

    openvdb::GridBase::Ptr read(const GridPlace& place) {
        const auto grid = open(place).first;
        grid->readTopology(stream_);
        grid->readBuffers(stream_);
        return grid;
    }

   private:
    void seek(uint64_t at) {
        stream_.clear();
        stream_.seekg(static_cast<std::streamoff>(at));
    }

    // The stream keeps a pointer to this pointer, so it has to outlive the stream.
    openvdb::io::StreamMetadata::Ptr metadata_ = std::make_shared<openvdb::io::StreamMetadata>();
    std::ifstream stream_;
};

File::File(std::unique_ptr<Stream> stream) : stream_(std::move(stream)) {}
File::~File() = default;

rust::Vec<MetadataText> File::metadata(uint64_t at) const {
    return texts_of(stream_->metadata(at));
}

GridHeader File::header(const GridPlace& place) const {
    GridHeader header{};
    header.voxel_count = -1;
    header.registered = openvdb::GridBase::isRegistered(std::string(place.tree_type));
    if (!header.registered) return header;
    const auto [grid, compression] = stream_->open(place);
    header.compression = compression;
    header.grid_class =
        rust::String::lossy(openvdb::GridBase::gridClassToString(grid->getGridClass()));
    const auto& transform = grid->constTransform();
    header.map = rust::String::lossy(transform.mapType());
    header.linear = transform.isLinear();
    if (header.linear) {
        const openvdb::Mat4d matrix = matrix_of(transform);
        for (int i = 0; i < 16; ++i) header.affine.push_back(matrix.asPointer()[i]);
    }
    using Count = openvdb::Int64Metadata;
    if (auto count = grid->getMetadata<Count>(openvdb::GridBase::META_FILE_VOXEL_COUNT)) {
        header.voxel_count = count->value();
    }
    header.metadata = texts_of(*grid);
    return header;
}

std::unique_ptr<Voxels> File::read(const GridPlace& place, bool fog) const {
    return extract(stream_->read(place), fog);
}

rust::String library_version() { return openvdb::getLibraryVersionString(); }

uint32_t newest_file_version() { return openvdb::OPENVDB_FILE_VERSION; }

std::unique_ptr<File> open_file(rust::Str path, std::array<uint32_t, 2> library, uint32_t format) {
    openvdb::initialize();  // Does its work once, under a lock of its own.
    const openvdb::VersionId version(library[0], library[1]);
    return std::make_unique<File>(
        std::make_unique<File::Stream>(std::string(path), version, format));
}

}  // namespace fogbow
