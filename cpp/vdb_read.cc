// Reading: the header and all metadata at once, voxels grid by grid.

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "fogbow/cpp/vdb_voxels.h"
#include "fogbow/src/vdb/ffi.rs.h"

namespace fogbow {

namespace {

constexpr int32_t kMostGrids = 100000;

struct Entry {
    openvdb::io::GridDescriptor descriptor;
    openvdb::GridBase::Ptr grid;  // Metadata and transform; empty where the type is not known.
    uint32_t compression = 0;
};

// The matrix of a linear transform; zeros where it is singular, which OpenVDB throws at.
openvdb::Mat4d matrix_of(const openvdb::math::Transform& transform) {
    try {
        return transform.baseMap()->getAffineMap()->getMat4();
    } catch (const openvdb::ArithmeticError&) {
        return openvdb::Mat4d::zero();
    }
}

GridHeader header_of(const Entry& entry) {
    GridHeader header{};
    header.name = rust::String::lossy(entry.descriptor.gridName());
    header.tree_type = rust::String::lossy(entry.descriptor.gridType());
    header.half = entry.descriptor.saveFloatAsHalf();
    header.compression = entry.compression;
    header.voxel_count = -1;
    header.registered = entry.grid != nullptr;
    if (!entry.grid) return header;
    header.grid_class =
        rust::String::lossy(openvdb::GridBase::gridClassToString(entry.grid->getGridClass()));
    const auto& transform = entry.grid->transform();
    header.map = rust::String::lossy(transform.mapType());
    header.linear = transform.isLinear();
    if (header.linear) {
        const openvdb::Mat4d matrix = matrix_of(transform);
        for (int i = 0; i < 16; ++i) header.affine.push_back(matrix.asPointer()[i]);
    }
    using Count = openvdb::Int64Metadata;
    if (auto count = entry.grid->getMetadata<Count>(openvdb::GridBase::META_FILE_VOXEL_COUNT)) {
        header.voxel_count = count->value();
    }
    return header;
}

}  // namespace

// openvdb::io::File ignores the state of its stream, so a truncated file would be read as garbage.
// This reader has its own stream, which throws.
class File::Reader : public openvdb::io::Archive {
   public:
    explicit Reader(const std::string& path) {
        stream_.exceptions(std::ios::failbit | std::ios::badbit);
        stream_.open(path, std::ios::binary);
        stream_.seekg(0, std::ios::end);
        const int64_t size = stream_.tellg();
        stream_.seekg(0);
        openvdb::io::setStreamMetadataPtr(stream_, metadata_, /*transfer=*/false);
        readHeader(stream_);
        setFormatVersion(stream_);
        setLibraryVersion(stream_);
        setDataCompression(stream_);
        openvdb::MetaMap().readMeta(stream_);
        const int32_t count = readGridCount(stream_);
        if (count < 0 || count > kMostGrids) throw std::runtime_error("impossible number of grids");
        for (int32_t i = 0; i < count; ++i) read_entry(size);
    }

    const std::vector<Entry>& entries() const { return entries_; }

    std::string library() const {
        const auto version = libraryVersion();
        return std::to_string(version.first) + "." + std::to_string(version.second);
    }

    openvdb::GridBase::Ptr read(size_t index) {
        const Entry& entry = entries_.at(index);
        if (!inputHasGridOffsets()) return entry.grid;
        auto grid = openvdb::GridBase::createGrid(entry.descriptor.gridType());
        grid->setSaveFloatAsHalf(entry.descriptor.saveFloatAsHalf());
        stream_.clear();
        entry.descriptor.seekToGrid(stream_);
        readGrid(grid, entry.descriptor, stream_);
        if (entry.descriptor.isInstance()) {
            grid->setTree(read(parent_of(entry.descriptor))->baseTreePtr());
        }
        return grid;
    }

   private:
    void read_entry(int64_t file_size) {
        Entry entry;
        auto& descriptor = entry.descriptor;
        try {
            entry.grid = descriptor.read(stream_);
        } catch (const openvdb::LookupError&) {
            // The type is not known. The descriptor has its names; the offsets come next.
            int64_t offsets[3];
            stream_.read(reinterpret_cast<char*>(offsets), sizeof offsets);
            descriptor.setGridPos(offsets[0]);
            descriptor.setBlockPos(offsets[1]);
            descriptor.setEndPos(offsets[2]);
        }
        if (!inputHasGridOffsets()) {
            // Written to a stream: the grids can only be read one after the other.
            if (!entry.grid)
                throw std::runtime_error("unknown grid type in a file without offsets");
            readGrid(entry.grid, descriptor, stream_);
            if (descriptor.isInstance()) {
                entry.grid->setTree(entries_.at(parent_of(descriptor)).grid->baseTreePtr());
            }
        } else {
            const int64_t here = stream_.tellg(), end = descriptor.getEndPos();
            if (descriptor.getGridPos() < here || end < descriptor.getGridPos() ||
                end > file_size) {
                throw std::runtime_error("grid \"" + std::string(descriptor.gridName()) +
                                         "\" should end at byte " + std::to_string(end) +
                                         ", but the file has " + std::to_string(file_size));
            }
            if (entry.grid) {
                descriptor.seekToGrid(stream_);
                readGridCompression(stream_);
                entry.compression = openvdb::io::getDataCompression(stream_);
                entry.grid->readMeta(stream_);
                entry.grid->readTransform(stream_);
            }
            descriptor.seekToEnd(stream_);
        }
        entries_.push_back(std::move(entry));
    }

    size_t parent_of(const openvdb::io::GridDescriptor& descriptor) const {
        for (size_t i = 0; i < entries_.size(); ++i) {
            const auto& other = entries_[i].descriptor;
            if (other.uniqueName() == descriptor.instanceParentName() && !other.isInstance()) {
                return i;
            }
        }
        throw std::runtime_error("the grid whose tree it shares is missing");
    }

    // The stream keeps a pointer to this pointer, so it has to outlive the stream.
    openvdb::io::StreamMetadata::Ptr metadata_ = std::make_shared<openvdb::io::StreamMetadata>();
    std::ifstream stream_;
    std::vector<Entry> entries_;
};

File::File(std::unique_ptr<Reader> reader) : reader_(std::move(reader)) {}
File::~File() = default;

rust::String File::library_of_writer() const { return reader_->library(); }

rust::Vec<GridHeader> File::headers() const {
    rust::Vec<GridHeader> headers;
    for (const auto& entry : reader_->entries()) headers.push_back(header_of(entry));
    return headers;
}

std::unique_ptr<Voxels> File::read(size_t index, bool fog) const {
    return extract(reader_->read(index), fog);
}

rust::String library_version() { return openvdb::getLibraryVersionString(); }

uint32_t newest_file_version() { return openvdb::OPENVDB_FILE_VERSION; }

std::unique_ptr<File> open_file(rust::Str path) {
    openvdb::initialize();  // Does its work once, under a lock of its own.
    return std::make_unique<File>(std::make_unique<File::Reader>(std::string(path)));
}

}  // namespace fogbow
