#include "map_use.h"

#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "support/small_maps.h"

namespace lamap::fuzz
{
namespace
{
using test::bytesOf;
constexpr size_t kManyCells = 1000;

/// Enough of the cells are seen.
struct Enough
{
};

/// @return number of cells, kManyCells + 1 at most
size_t askAboutCells(const CLearnedMap& map)
{
  size_t cells = 0;
  try
  {
    map.visitCells(
        [&](const CellIndex& cell, const CellEstimate& estimate)
        {
          if (!(estimate.prob >= 0 && estimate.prob <= 1)) breakPromise("a probability is from 0 to 1");
          if (cells % 16 == 0 && !map.estimateCell(cell)) breakPromise("a visited cell has an estimate");
          if (++cells > kManyCells) throw Enough();
        });
  }
  catch (const Enough&)
  {
  }
  return cells;
}

/// Of a laser that sees only half a metre: under the sanitizers, every cell counts.
mrpt::obs::CObservation2DRangeScan shortScan()
{
  mrpt::obs::CObservation2DRangeScan scan;
  scan.aperture = 1;
  scan.maxRange = 0.5F;
  scan.resizeScan(5);
  for (size_t i = 0; i < 5; ++i)
  {
    scan.setScanRange(i, 0.3F + 0.05F * static_cast<float>(i));
    scan.setScanRangeValidity(i, i != 4);
  }
  return scan;
}

template <typename Map>
void mergeWithCopy(CLearnedMap& map)
{
  auto* own = dynamic_cast<Map*>(&map);
  if (own == nullptr) return;
  const Map other = *own;
  tryTo([&] { own->merge(other); });
}
}  // namespace

void breakPromise(const char* promise)
{
  std::fprintf(stderr, "broken: %s\n", promise);
  std::abort();
}

void quieten(CLearnedMap& map)
{
  map.setThreadCount(1);
  map.setMinLoggingLevel(mrpt::system::LVL_ERROR);
  map.logging_enable_console_output = false;
}

std::shared_ptr<CLearnedMap> mapFrom(const std::vector<uint8_t>& bytes)
{
  mrpt::io::CMemoryStream stream;
  stream.assignMemoryNotOwn(bytes.data(), bytes.size());
  auto archive = mrpt::serialization::archiveFrom(stream);
  return std::dynamic_pointer_cast<CLearnedMap>(archive.ReadObject());
}

void requireSaves(const CLearnedMap& map)
{
  const std::vector<uint8_t> saved = bytesOf(map);
  if (bytesOf(*mapFrom(saved)) != saved) breakPromise("save, load, save gives the same bytes");
}

void ask(const CLearnedMap& map)
{
  const size_t cells = askAboutCells(map);
  (void)map.estimateAt({1, 0.2, 0.3});
  (void)map.estimateAt({1e300, -1e300, 1e12});
  (void)map.estimateAt({NAN, 0, 0});
  (void)map.estimateCell({INT32_MAX, INT32_MIN, INT32_MAX});
  if (cells > kManyCells) return;
  (void)map.asString();
  (void)map.boundingBox();
  mrpt::math::TPoint3D end;
  (void)map.castRay({0.1, 0.2, 0.3}, {1, 0.1, 0}, end, true, 0);
  (void)map.castRay({-1, 0, 0}, {1, 0, 0.01}, end, false, 20);
  const double likelihood = map.computeObservationLikelihood(shortScan(), {});
  if (!std::isfinite(likelihood)) breakPromise("a likelihood is finite");
  const auto objects = mrpt::opengl::CSetOfObjects::Create();
  map.getVisualizationInto(*objects);
}

void change(CLearnedMap& map)
{
  tryTo([&] { map.updateVoxel(0.5, 0.5, 0.5, true); });
  tryTo([&] { map.updateVoxel(-0.5, 0.5, 0.5, false); });
  tryTo([&] { map.insertRay(0.4F, 0.2F, 0.1F, 0, 0, 0); });
  (void)map.insertObservation(shortScan());
  if (auto* models = dynamic_cast<COverlappingHilbertMap*>(&map);
      models != nullptr && models->modelCount() > 0)
    tryTo(
        [&]
        {
          const mrpt::poses::CPose3D step(0.3, 0.1, 0, 0.1, 0, 0);
          models->setModelPose(0, models->modelPose(0) + step);
        });
  mergeWithCopy<CBGKMap>(map);
  mergeWithCopy<CGPMap>(map);
  mergeWithCopy<COverlappingHilbertMap>(map);
}

}  // namespace lamap::fuzz
