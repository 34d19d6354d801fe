#pragma once

#include <lamap_tools/inputs/pose_track.h>
#include <lamap_tools/inputs/scan_source.h>

#include <memory>
#include <string>
#include <vector>

namespace lamap::tools
{
/** PCD files, and folders of them, as openInputs() describes.
 * @param paths  of files and folders
 * @param poses  of InputOptions::posesPath; empty: none
 * @return one source for each path
 * @throws std::runtime_error as openInputs() */
[[nodiscard]] std::vector<std::unique_ptr<ScanSource>> openPcdSources(const std::vector<std::string>& paths,
                                                                      const std::vector<TimedPose>& poses,
                                                                      const InputOptions& options);

}  // namespace lamap::tools
