// What vdb_read.cc and vdb_voxels.cc share; it includes OpenVDB, so the glue must not.
#pragma once

#include <openvdb/openvdb.h>

#include <memory>

#include "fogbow/cpp/vdb.h"

namespace fogbow {

// Copies a grid's leaves and tiles into plain arrays; throws where its type holds neither scalars
// nor three-vectors. `fog` turns a level set into a fog volume first. Nobody else may hold the
// grid, which is changed in place.
std::unique_ptr<Voxels> extract(openvdb::GridBase::Ptr grid, bool fog);

}  // namespace fogbow
