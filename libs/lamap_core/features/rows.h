#pragma once

#include <lamap_core/features/compact_kernel.h>
#include <lamap_core/features/site_set.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/training/hilbert_training.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace lamap
{
/** The features F of training points, one row per point: log-odds at the points are F·u for weights u.
 *
 * A row is a list of runs of `width` neighbouring weights. Numbers between those of features stand for
 * nothing: their values are 0. Points lie in chunks whose sizes depend on their number alone, and sums over
 * chunks are added in their order, so the number of threads changes no bit.
 */
class FeatureRows
{
 public:
  struct Run
  {
    uint32_t first;       ///< number of the first weight
    const float* values;  ///< `width` of them
  };

  /** @param width of a run, a multiple of 4; @param points in all
   *  @param weights how many numbers there are, each run's end included
   *  @param used those that stand for features, ascending */
  void reset(int width, size_t points, size_t weights, std::vector<uint32_t> used);

  [[nodiscard]] size_t points() const { return points_; }
  [[nodiscard]] size_t weights() const { return weights_; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] const std::vector<uint32_t>& used() const { return used_; }
  /// The weight that is no feature's but the bias: its value is 1 in each row.
  [[nodiscard]] std::optional<uint32_t> bias() const { return bias_; }
  void setBias(uint32_t number) { bias_ = number; }

  // Filling: chunk by chunk, its points in their order; different chunks may be filled from different
  // threads.
  [[nodiscard]] size_t chunkCount() const { return chunks_.size(); }
  [[nodiscard]] size_t firstPointOf(size_t chunk) const { return chunk * chunkSize_; }
  [[nodiscard]] size_t endPointOf(size_t chunk) const { return std::min(points_, (chunk + 1) * chunkSize_); }
  /// Adds a run to the point being filled. @return its `width` values, to be set.
  float* addRun(size_t chunk, uint32_t first);
  void endPoint(size_t chunk);
  /// Adds all runs of a point and ends it. @param values `width` for each of firsts
  void addPoint(size_t chunk, const std::vector<uint32_t>& firsts, const float* values);
  /// The values of a point that has one run.
  [[nodiscard]] const float* valuesOf(size_t point) const;
  /// Whether each point has one run, of all weights.
  [[nodiscard]] bool dense() const;

  /// f = F·u. @param u weights() numbers; @param f points() numbers
  void multiply(const float* u, float* f, const Workers& workers) const;
  /// g = Fᵀ·r, 0 where there is no feature.
  void multiplyTransposed(const float* r, float* g, const Workers& workers);
  /// d_j = Σᵢ cᵢ·F_ij², 0 where there is no feature.
  void addSquares(const float* c, float* d, const Workers& workers);

  // Single rows.
  [[nodiscard]] float dot(size_t point, const float* u) const;
  /// u += factor · row
  void addTo(size_t point, float factor, float* u) const;
  template <typename Visit>
  void forEachRun(size_t point, Visit&& visit) const;
  /// Has the processor fetch a row that will be asked for soon.
  void prefetch(size_t point) const;

 private:
  struct Chunk
  {
    std::vector<uint32_t> runEnds;  ///< of each point
    std::vector<uint32_t> firsts;   ///< of each run
    std::vector<float> values;
    std::vector<float> sums;  ///< working memory of multiplyTransposed()
  };

  template <bool kSquared>
  void transposed(const float* r, float* g, const Workers& workers);

  int width_ = 4;
  size_t points_ = 0;
  size_t weights_ = 0;
  size_t chunkSize_ = 1;
  std::vector<uint32_t> used_;
  std::optional<uint32_t> bias_;
  std::vector<Chunk> chunks_;
};

template <typename Visit>
void FeatureRows::forEachRun(size_t point, Visit&& visit) const
{
  const Chunk& chunk = chunks_[point / chunkSize_];
  const size_t i = point % chunkSize_;
  const size_t begin = i == 0 ? 0 : chunk.runEnds[i - 1];
  for (size_t run = begin; run < chunk.runEnds[i]; ++run)
    visit(Run{chunk.firsts[run], chunk.values.data() + run * static_cast<size_t>(width_)});
}

/** Which sites of a lattice a training set teaches, and the rows of its compact features.
 *
 * Keeps its working memory from scan to scan. Sites are counted from the frame's anchor site plus `shift`. */
class CompactRows
{
 public:
  /** Finds the sites that hold a point of the set: where a scan has its features. More may be inserted within
   * reach_sites() of them.
   * @param shift added to sites, so that their blocks may lie on those of a larger lattice
   * Points that are too uncertain to reach anything hold no site. */
  void findSites(const HilbertTrainingSet& set, const CompactKernel& kernel, double spacing_m, bool planar,
                 const CellIndex& shift);

  /// The sites with features: those that hold a point, unless more were inserted.
  [[nodiscard]] SiteSet& sites() { return sites_; }

  /// How many steps along each axis a point's kernel reaches from the site that holds it, at most.
  [[nodiscard]] int reach_sites() const { return reach_sites_; }

  /// Makes the rows over sites().
  void build(const HilbertTrainingSet& set, const Workers& workers);

  [[nodiscard]] FeatureRows& rows() { return rows_; }
  [[nodiscard]] const SiteNumbers& numbers() const { return numbers_; }

 private:
  /// What one chunk's points share while their rows are made.
  struct Builder;
  void addCertain(const Eigen::Vector3d& point, size_t chunk, Builder& builder);
  void addUncertain(const Eigen::Vector3d& point, const GaussianBlur& blur, size_t chunk);
  [[nodiscard]] int runWidth(const HilbertTrainingSet& set) const;

  CompactKernel kernel_;
  double spacing_m_ = 0.25;
  bool planar_ = false;
  CellIndex shift_;
  int reach_sites_ = 0;
  std::vector<Eigen::Vector3d> reaches_m_;  ///< of uncertain points
  SiteSet sites_;
  SiteNumbers numbers_;
  FeatureRows rows_;
};

}  // namespace lamap
