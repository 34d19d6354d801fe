#pragma once

#include <lamap_tools/inputs/pose_track.h>
#include <lamap_tools/inputs/scan_source.h>

#include <memory>
#include <string>

namespace lamap::tools
{
/** The observations of a rawlog with the robot's poses, as openInputs() describes.
 * @param givenPoses  replace the log's own; nullptr: none
 * @throws std::runtime_error as openInputs() */
[[nodiscard]] std::unique_ptr<ScanSource> openRawlogSource(const std::string& path,
                                                           std::shared_ptr<const PoseTrack> givenPoses,
                                                           const InputOptions& options);

}  // namespace lamap::tools
