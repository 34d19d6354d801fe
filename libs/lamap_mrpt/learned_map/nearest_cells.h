#pragma once

#include <lamap_mrpt/compat/mrpt_compat.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace lamap
{
#if LAMAP_MRPT_SINCE_2_11_3
/** Nearest occupied cells through MRPT's general interface; a cell's index is that in getAsSimplePointsMap().
 * All methods may be called from several threads as long as no thread modifies the map.
 */
class NearestCells : public mrpt::maps::NearestNeighborsCapable
{
 public:
  bool nn_has_indices_or_ids() const override { return true; }
  size_t nn_index_count() const override { return cellsToSearch(false)->size(); }
  void nn_prepare_for_2d_queries() const override { (void)cellsToSearch(true); }
  void nn_prepare_for_3d_queries() const override { (void)cellsToSearch(false); }

  bool nn_single_search(const mrpt::math::TPoint3Df& query, mrpt::math::TPoint3Df& result,
                        float& squaredDistance, uint64_t& index) const override
  {
    const auto cells = cellsToSearch(false);
    return !cells->empty() && cells->nn_single_search(query, result, squaredDistance, index);
  }
  bool nn_single_search(const mrpt::math::TPoint2Df& query, mrpt::math::TPoint2Df& result,
                        float& squaredDistance, uint64_t& index) const override
  {
    const auto cells = cellsToSearch(true);
    return !cells->empty() && cells->nn_single_search(query, result, squaredDistance, index);
  }
  void nn_multiple_search(const mrpt::math::TPoint3Df& query, const size_t count,
                          std::vector<mrpt::math::TPoint3Df>& results, std::vector<float>& squaredDistances,
                          std::vector<uint64_t>& indices) const override
  {
    searchMany(false, results, squaredDistances, indices,
               [&](const mrpt::maps::CSimplePointsMap& cells)
               { cells.nn_multiple_search(query, count, results, squaredDistances, indices); });
  }
  void nn_multiple_search(const mrpt::math::TPoint2Df& query, const size_t count,
                          std::vector<mrpt::math::TPoint2Df>& results, std::vector<float>& squaredDistances,
                          std::vector<uint64_t>& indices) const override
  {
    searchMany(true, results, squaredDistances, indices,
               [&](const mrpt::maps::CSimplePointsMap& cells)
               { cells.nn_multiple_search(query, count, results, squaredDistances, indices); });
  }
  void nn_radius_search(const mrpt::math::TPoint3Df& query, const float squaredRadius,
                        std::vector<mrpt::math::TPoint3Df>& results, std::vector<float>& squaredDistances,
                        std::vector<uint64_t>& indices, size_t most) const override
  {
    searchMany(false, results, squaredDistances, indices,
               [&](const mrpt::maps::CSimplePointsMap& cells)
               { cells.nn_radius_search(query, squaredRadius, results, squaredDistances, indices, most); });
  }
  void nn_radius_search(const mrpt::math::TPoint2Df& query, const float squaredRadius,
                        std::vector<mrpt::math::TPoint2Df>& results, std::vector<float>& squaredDistances,
                        std::vector<uint64_t>& indices, size_t most) const override
  {
    searchMany(true, results, squaredDistances, indices,
               [&](const mrpt::maps::CSimplePointsMap& cells)
               { cells.nn_radius_search(query, squaredRadius, results, squaredDistances, indices, most); });
  }

 protected:
  /// The occupied cells, ready for searches in the plane or in space.
  [[nodiscard]] virtual std::shared_ptr<const mrpt::maps::CSimplePointsMap> cellsToSearch(
      bool plane) const = 0;

 private:
  template <typename Results, typename Search>
  void searchMany(bool plane, Results& results, std::vector<float>& squaredDistances,
                  std::vector<uint64_t>& indices, const Search& search) const
  {
    results.clear();
    squaredDistances.clear();
    indices.clear();
    const auto cells = cellsToSearch(plane);
    if (!cells->empty()) search(*cells);
  }
};
#else
/// MRPT has the interface since 2.11.3.
class NearestCells
{
 protected:
  ~NearestCells() = default;
  [[nodiscard]] virtual std::shared_ptr<const mrpt::maps::CSimplePointsMap> cellsToSearch(
      bool plane) const = 0;
};
#endif

}  // namespace lamap
