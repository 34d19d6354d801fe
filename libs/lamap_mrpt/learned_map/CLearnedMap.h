#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/state_thresholds.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/learned_map/lazy.h>
#include <lamap_mrpt/learned_map/nearest_cells.h>
#include <lamap_mrpt/options/option_group.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/math/TBoundingBox.h>
#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/poses/CPose3DPDF.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/system/COutputLogger.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace lamap
{
class CellProbs;
class EndPointLikelihood;
struct EndPoints;
class OccupiedCells;
struct ObservedBox;
struct RayStretch;
struct RayWalk;

/** Base of all learned occupancy maps of this library, whatever their learner.
 *
 * A learner implements learnScan(), the estimates, its options and its serialization. This class derives from
 * them what MRPT expects of a map: likelihood, matching, ray casting, views and files.
 *
 * Thread guarantee: const methods may be called from several threads as long as no thread modifies the map.
 */
class CLearnedMap : public mrpt::maps::CMetricMap, public NearestCells, public mrpt::system::COutputLogger
{
 public:
  /// Edge of a finest cell [m].
  [[nodiscard]] virtual double resolution() const = 0;

  /// The estimate at a point of the map frame [m]; empty where there is no evidence.
  [[nodiscard]] virtual std::optional<CellEstimate> estimateAt(
      const mrpt::math::TPoint3D& point_map) const = 0;

  using CellVisitor = std::function<void(const CellIndex&, const CellEstimate&)>;
  /// Calls the visitor once for every finest cell with evidence, with pruned ones expanded, in unspecified
  /// order.
  virtual void visitCells(const CellVisitor& visitor) const = 0;

  /// The smallest and the largest index of these cells along each axis; nothing if there are none.
  [[nodiscard]] virtual std::optional<std::pair<CellIndex, CellIndex>> cellBounds() const = 0;
  /// A cube of 2^n cells around a cell, aligned to its size, and those beside it hold none of these cells.
  /// @return the largest n that is known, or 0
  [[nodiscard]] virtual int emptyAround(const CellIndex& cell) const = 0;

  /// Names of CellEstimate::evidence, in its order; one or two.
  [[nodiscard]] virtual std::vector<std::string> evidenceNames() const = 0;

  /// The short name in .ini files, e.g. "bgkMap".
  [[nodiscard]] virtual std::string alias() const = 0;

  /// A fact about the map, for a report.
  struct Fact
  {
    std::string name;
    std::variant<uint64_t, double> number;  ///< a count or a measure
    std::string unit{};                     ///< "" for a plain number

    /// The number; a measure is rounded to six digits.
    [[nodiscard]] std::string text() const;
  };
  [[nodiscard]] virtual std::vector<Fact> facts() const = 0;

  /// What became of the rays of the observations that were inserted since the map was made or loaded.
  [[nodiscard]] const RayCounts& rayCounts() const { return tallied_; }

  /// Memory of the map's content [bytes], including all indices, without buffers that only speed up the next
  /// scan.
  [[nodiscard]] virtual size_t memoryBytes() const = 0;

  /// Number of threads that an insertion may use; 0 (the default): as many as the machine has. Never changes
  /// a result.
  void setThreadCount(unsigned threads) { threadCount_ = threads; }
  [[nodiscard]] unsigned threadCount() const { return threadCount_; }

  /** Adds one scan.
   * @return false if no ray of it was usable.
   * @throws std::invalid_argument if the insertion options are illegal. */
  bool insertScan(const Scan& scan);

  /** As insertObservation(), but throws where that one leaves an observation out with a message on the log.
   * @param uncertainPose_map the same pose with its covariance; null: it counts as certain
   * @return false if it has no class that this map takes, or no ray that is usable
   * @throws std::exception saying why it cannot be read or learned; the map is as it was then */
  bool learnObservation(const mrpt::obs::CObservation& observation, const mrpt::poses::CPose3D& robotPose_map,
                        const mrpt::poses::CPose3DPDF* uncertainPose_map = nullptr);

  /** As insertObservation(), at an uncertain pose. Learners that take uncertain inputs use its covariance as
   * their options say; the others only its mean. */
  bool insertObservationAt(const mrpt::obs::CObservation& observation,
                           const mrpt::poses::CPose3DPDF& robotPose_map);

  // ---- Further members for a learner ----

  /// The estimate of a cell; empty if it has no evidence.
  [[nodiscard]] virtual std::optional<CellEstimate> estimateCell(const CellIndex& cell) const;

  /// The single layer of cells of a planar map, at all heights of a point; empty for a map in 3D.
  [[nodiscard]] virtual std::optional<int32_t> planarLayer() const { return std::nullopt; }

  /// The thresholds for free and occupied cells, by the current insertion options.
  [[nodiscard]] virtual StateThresholds stateThresholds() const = 0;

  /// The rays that are used, by the current insertion options.
  [[nodiscard]] virtual RangeOptions rangeLimits() const = 0;

  /** Adds the evidence of one hit or one free point at the centre of a cell.
   * @throws std::invalid_argument if the point is beyond what cells can address. */
  virtual void updateVoxel(double x, double y, double z, bool occupied) = 0;

  /** Calls the visitor for creationOpts, insertOpts, likelihoodOpts and renderOpts: with the map's options,
   * lengths in cells resolved, and with a new group of the same class, which the visitor may change. */
  using VisitGroup = std::function<void(const TOptionGroup& now, TOptionGroup& untouched)>;
  virtual void visitOptionGroups(const VisitGroup& visit) const = 0;

  /// Every option of every group.
  [[nodiscard]] std::vector<OptionValue> optionValues() const;

  /** Whether an option already has the value that a text states; e.g. "30" and "3e1" are equal.
   * @param section e.g. "insertOpts"; @param key e.g. "maxRange", not case-sensitive.
   * @throws std::invalid_argument if there is no such option (naming the nearest) or the text is not legal.
   */
  [[nodiscard]] bool optionIs(const std::string& section, const std::string& key,
                              const std::string& text) const;

  // ---- Options ----

  /** How well an observation fits the map at a pose, for particle filters: see end_point_likelihood.h. An
   * illegal option throws std::invalid_argument when a likelihood is computed, and when the map is saved. */
  struct TLikelihoodOptions : public OptionGroup<TLikelihoodOptions>
  {
    uint32_t decimation = 5;  ///< use every Nth ray of an observation
    double outlierProb =
        0.3;  ///< share of returns that carry no information: half of it is the least one counts
    double endPointStd = 0.2;  ///< [m] uncertainty of where a return ends; 0: only the cell it ends in counts
    double freeBefore = 0;     ///< [m] a ray must be free this far before its end; 0: only its end counts
    double unobservedProb = 0.25;  ///< P(occupied) that counts for a return where the map has no evidence
    double independence = 0.15;    ///< how much of a return counts as independent of the others

    [[nodiscard]] const OptionTable& optionTable() const override;
  };
  TLikelihoodOptions likelihoodOptions;

  /// Quantity that colours the cubes of a view.
  enum class ColourBy
  {
    Height,
    Probability,
    Variance
  };

  /// How the map becomes a COctoMapVoxels. An illegal option throws std::invalid_argument when the map is
  /// drawn, and when it is saved.
  struct TRenderingOptions : public OptionGroup<TRenderingOptions>
  {
    bool generateOccupiedVoxels = true;
    bool visibleOccupiedVoxels = true;
    bool generateFreeVoxels = false;
    bool visibleFreeVoxels = true;
    bool generateGridLines = false;  ///< a wire box around the map's observed cells
    bool hideBuriedVoxels = true;    ///< omit occupied cells without a visible side
    ColourBy colourBy = ColourBy::Height;
    double freeOpacity = 0.1;

    [[nodiscard]] const OptionTable& optionTable() const override;
  };
  TRenderingOptions renderingOptions;

  // ---- As in COctoMap ----

  /// P(occupied) at a point [m]. @return false, leaving prob alone, where the map has no evidence.
  bool getPointOccupancy(float x, float y, float z, double& prob) const;

  /** Follows a ray from cell to cell to the first occupied one.
   * @param direction of any length > 0. @param end centre of that cell, otherwise of the last one visited.
   * @param ignoreUnknownCells if false, a cell without evidence ends the ray; one with evidence but an
   * unknown state does not, because there are always some in front of a wall.
   * @param maxRange [m], cells that the ray enters beyond it are not visited; <= 0: no limit.
   * @return whether an occupied cell was met; that of the origin counts. */
  bool castRay(const mrpt::math::TPoint3D& origin, const mrpt::math::TPoint3D& direction,
               mrpt::math::TPoint3D& end, bool ignoreUnknownCells = false, double maxRange = -1.0) const;

  /// Adds one ray with a return at its end [m].
  void insertRay(float end_x, float end_y, float end_z, float sensor_x, float sensor_y, float sensor_z);
  /// Adds a scan: points in the map frame, and the origin of their rays [m].
  void insertPointCloud(const mrpt::maps::CPointsMap& points, float sensor_x, float sensor_y, float sensor_z);

  /// The map as cubes; see TRenderingOptions. Far from the origin, relative to their pose, which is set.
  void getAsOctoMapVoxels(mrpt::opengl::COctoMapVoxels& voxels) const;

  // ---- CMetricMap ----

  void getVisualizationInto(mrpt::opengl::CSetOfObjects& scene) const override;

  /** Writes prefix.lamap.gz, prefix.3Dscene and prefix.ply (occupied cells), each completely or not at all.
   * @throws std::runtime_error naming the file and the reason. */
  void saveMetricMapRepresentationToFile(const std::string& prefix) const override;

  /// A description in one paragraph.
  std::string asString() const override;

  /** Centres of the occupied cells in the order of z, y, x. Owned by the map; valid until the map or its
   * thresholds change. */
  const mrpt::maps::CSimplePointsMap* getAsSimplePointsMap() const override;

  /** Pairs of occupied cells and points of the other map, by CPointsMap's rules. The other map may be a
   * points map, a learned map (its occupied cells), or a CMultiMetricMap that has either.
   * @throws std::invalid_argument if the other map has no points. */
  void determineMatching2D(const mrpt::maps::CMetricMap* otherMap, const mrpt::poses::CPose2D& otherMapPose,
                           mrpt::tfest::TMatchingPairList& correspondences,
                           const mrpt::maps::TMatchingParams& params,
                           mrpt::maps::TMatchingExtraResults& extraResults) const override;
  void determineMatching3D(const mrpt::maps::CMetricMap* otherMap, const mrpt::poses::CPose3D& otherMapPose,
                           mrpt::tfest::TMatchingPairList& correspondences,
                           const mrpt::maps::TMatchingParams& params,
                           mrpt::maps::TMatchingExtraResults& extraResults) const override;
  /// Share of the other map's points with an occupied cell nearby; 0 if it has no points.
  float compute3DMatchingRatio(const mrpt::maps::CMetricMap* otherMap,
                               const mrpt::poses::CPose3D& otherMapPose,
                               const mrpt::maps::TMatchingRatioParams& params) const override;
  /// Squared distance in the plane to the nearest centre of an occupied cell [m²]; the largest float if there
  /// is none.
  float squareDistanceToClosestCorrespondence(float x0, float y0) const override;

  /// Box of all cells with evidence [m]; MRPT's empty box if there are none.
  mrpt::math::TBoundingBoxf boundingBox() const LAMAP_OVERRIDE_SINCE_2_11_3;

  void auxParticleFilterCleanUp() override;

 protected:
  CLearnedMap() = default;
  /// Neither observers of the other map nor data derived from its cells are copied.
  CLearnedMap(const CLearnedMap& other);
  CLearnedMap& operator=(const CLearnedMap& other);

  /// Learns a scan; if it throws, the map is as it was. @return what became of its rays
  virtual RayCounts learnScan(const Scan& scan) = 0;
  /// The first occupied cell along a ray; a learner may be quicker than by asking cell by cell.
  [[nodiscard]] virtual RayWalk follow(const RayStretch& ray) const;
  /// @throws std::invalid_argument naming an illegal insertion option, its value and what is legal
  virtual void requireLegalInsertion() const = 0;

  /// Must be called after every change of cells.
  virtual void contentChanged();

  /// Calls a function with what answers for many cells one after another; a learner may be quicker than by
  /// estimateCell().
  using UseProbs = std::function<void(CellProbs&)>;
  virtual void withProbs(const UseProbs& use) const;

  /// The cell at a point [m]. @throws std::invalid_argument naming the caller and the point if there is none
  [[nodiscard]] CellIndex addressableCell(const char* caller, double x, double y, double z) const;

  /// Number of cells in each state. @param also called for each cell during the count
  [[nodiscard]] std::vector<Fact> cellFacts(const CellVisitor& also = {}) const;
  /// What became of the scans of this session.
  [[nodiscard]] std::vector<Fact> scanFacts() const;

  void OnPostSuccesfulInsertObs(const mrpt::obs::CObservation&) override { contentChanged(); }

 private:
  friend class EndPointLikelihood;

  /// Another number after each change of cells.
  [[nodiscard]] uint32_t contentChanges() const { return contentChanges_; }

  bool internal_insertObservation(
      const mrpt::obs::CObservation& observation,
      const std::optional<const mrpt::poses::CPose3D>& robotPose = std::nullopt) override;
  double internal_computeObservationLikelihood(const mrpt::obs::CObservation& observation,
                                               const mrpt::poses::CPose3D& takenFrom) const override;
  bool internal_canComputeObservationLikelihood(const mrpt::obs::CObservation& observation) const override;

  std::shared_ptr<const mrpt::maps::CSimplePointsMap> cellsToSearch(bool plane) const override;
  /// Counts a scan's rays by their use, and reports each kind of skipped ray once. @return whether any was
  /// used.
  bool tally(const RayCounts& counts);
  [[nodiscard]] std::shared_ptr<const OccupiedCells> occupiedCells() const;
  [[nodiscard]] std::shared_ptr<const ObservedBox> observedBox() const;

  unsigned threadCount_ = 0;
  uint32_t contentChanges_ = 0;
  /// Pose of the observation that is being inserted.
  std::optional<mrpt::poses::CPose3DPDFGaussian> uncertainPose_;
  RayCounts tallied_;
  size_t scansUsed_ = 0;
  size_t scansFailed_ = 0;  ///< observations that could not be read or learned
  Lazy<EndPoints> endPoints_;
  Lazy<EndPointLikelihood> likelihood_;
  Lazy<OccupiedCells> occupied_;
  Lazy<ObservedBox> box_;
};

}  // namespace lamap
