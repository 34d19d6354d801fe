#include <lamap_tools/inputs/simple_map_file.h>

#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_tools/inputs/memory_guard.h>
#include <lamap_tools/inputs/trial_run.h>

#include <filesystem>
#include <stdexcept>

namespace lamap::tools
{
mrpt::maps::CSimpleMap readSimpleMap(const std::string& path, const std::function<bool()>& shouldStop)
{
  mrpt::maps::CSimpleMap map;
  const auto tryReading = [&path](const std::function<void()>& step)
  {
    constexpr size_t kSmallest = size_t{2} << 30;
    const MemoryGuard guard(kSmallest + 64 * std::filesystem::file_size(path));
    mrpt::maps::CSimpleMap trial;
    if (trial.loadFromFile(path)) step();
    return std::vector<uint8_t>();
  };
  const TrialRun trial = tryInChild(tryReading, shouldStop);
  if (trial.stopped) return map;
  if (trial.steps == 0 || !map.loadFromFile(path))
    throw std::runtime_error(path + ": not a simple map, cut short or damaged");
  for (size_t i = 0; i < map.size(); ++i)
  {
    const auto keyframe = compat::keyframeAt(map, i);
    if (!keyframe.frame || !keyframe.pose)
      throw std::runtime_error(path + ": a pose or its observations are missing");
  }
  return map;
}

}  // namespace lamap::tools
