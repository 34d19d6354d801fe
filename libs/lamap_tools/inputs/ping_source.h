#pragma once

#include <lamap_tools/inputs/pose_track.h>
#include <lamap_tools/inputs/scan_source.h>

#include <memory>
#include <string>

namespace lamap::tools
{
/** The pings of a scanning sonar in a CSV file, as openInputs() describes.
 * @param track  the robot's poses; null: it stood still at the origin
 * @throws std::runtime_error as PingFile::read() */
[[nodiscard]] std::unique_ptr<ScanSource> openPingSource(const std::string& path,
                                                         std::shared_ptr<const PoseTrack> track,
                                                         const InputOptions& options);

}  // namespace lamap::tools
