// Any options and any sequence of operations: each is done or refused, and the map saves to a file that
// loads.
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include "fuzz_input.h"
#include "map_use.h"
#include "support/made_maps.h"

namespace
{
using namespace lamap;
using namespace lamap::fuzz;

std::string textFor(const Option& option, FuzzInput& input)
{
  if (option.type == OptionType::Choice) return option.names[input.below(option.names.size())];
  if (option.type == OptionType::Flag) return input.yesOrNo() ? "true" : "false";
  if (option.type == OptionType::Text) return "";
  if (option.type == OptionType::Number)
  {
    if (input.below(8) == 0) return shortText(input.number());
    const double low = std::max(option.range.low, -6.4);
    const double span = std::min(option.range.high - low, 6.4);
    return shortText(low + span / 64 * static_cast<double>(input.below(65)));
  }
  return std::to_string(static_cast<int>(input.below(64)) - 1);
}

template <typename Map>
test::Settings settingsFor(FuzzInput& input)
{
  std::vector<std::pair<std::string, Option>> options;
  Map().visitOptionGroups(
      [&](const TOptionGroup& group, TOptionGroup& /*untouched*/)
      {
        for (const Option& option : group.optionTable().options())
          options.emplace_back(group.optionTable().name(), option);
      });
  std::map<std::string, std::string> settings;
  for (size_t count = input.below(6); count > 0; --count)
  {
    const auto& [section, option] = options[input.below(options.size())];
    settings[section + "." + option.key] = textFor(option, input);
  }
  settings.try_emplace("creationOpts.resolution", "1");  // few cells: each counts under the sanitizers
  return {settings.begin(), settings.end()};
}

/// A few rays from anywhere to anywhere.
Scan scanFor(FuzzInput& input)
{
  constexpr RayEnd kEnds[] = {RayEnd::Return, RayEnd::NoReturn, RayEnd::Cut, RayEnd::Dropped};
  Scan scan;
  RayFan& fan = scan.fans.emplace_back();
  fan.centre = {input.number(), input.number(), input.number()};
  if (input.yesOrNo()) fan.statedRangeMax_m = std::abs(input.number());
  if (input.yesOrNo())
    fan.beam.halfWidth_rad = fan.beam.halfHeight_rad = 0.05 * static_cast<double>(input.below(20));
  if (input.yesOrNo()) scan.poseCovariance = Scan::PoseCovariance::Identity() * input.number();
  for (size_t rays = 1 + input.below(6); rays > 0; --rays)
  {
    const double x = input.number();
    const double y = input.number();
    fan.rays.push_back(
        {{x, y, input.number()}, kEnds[input.below(std::size(kEnds))], static_cast<uint8_t>(input.below(3))});
  }
  return scan;
}

template <typename Map>
void operate(Map& map, FuzzInput& input)
{
  switch (input.below(10))
  {
    case 0:
    case 1:
    case 2:
      tryTo([&] { (void)map.insertScan(scanFor(input)); });
      break;
    case 3:
      tryTo([&] { map.updateVoxel(input.number(), input.number(), input.number(), input.yesOrNo()); });
      break;
    case 4:
    {
      mrpt::maps::CSimplePointsMap points;
      for (size_t count = input.below(8); count > 0; --count)
        points.insertPoint(input.shortNumber(), input.shortNumber(), input.shortNumber());
      tryTo([&] { map.insertPointCloud(points, 0, 0, 0.5F); });
      break;
    }
    case 5:
    {
      mrpt::math::TPoint3D end;
      const mrpt::math::TPoint3D from(input.number(), input.number(), input.number());
      const mrpt::math::TPoint3D along(input.number(), input.number(), input.number());
      tryTo([&] { (void)map.castRay(from, along, end, input.yesOrNo(), input.number()); });
      break;
    }
    case 6:
      ask(map);
      break;
    case 7:
      change(map);
      break;
    case 8:
      if constexpr (std::is_same_v<Map, COverlappingHilbertMap>)
      {
        if (map.modelCount() > 0)
          tryTo([&] { map.setModelPose(input.below(map.modelCount()), input.pose()); });
      }
      else
        map = Map(map);
      break;
    default:
      requireSaves(map);
  }
}

template <typename Map>
void run(FuzzInput& input)
{
  std::optional<Map> map;
  if (!tryTo([&] { map.emplace(test::made<Map>(settingsFor<Map>(input), lamap::test::aliasOf<Map>())); }))
    return;
  quieten(*map);
  constexpr int kMostOperations = 6;
  for (int i = 0; i < kMostOperations && !input.isEmpty(); ++i) operate(*map, input);
  ask(*map);
  requireSaves(*map);
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
  FuzzInput input(bytes, size);
  switch (input.below(4))
  {
    case 0:
      run<CBGKMap>(input);
      break;
    case 1:
      run<CGPMap>(input);
      break;
    case 2:
      run<CHilbertMap>(input);
      break;
    default:
      run<COverlappingHilbertMap>(input);
  }
  return 0;
}
