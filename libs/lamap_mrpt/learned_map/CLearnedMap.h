#pragma once

#include <lamap_core/bgk/options.h>
#include <lamap_core/grid/cell.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/learned_map/lazy.h>
#include <lamap_mrpt/learned_map/nearest_cells.h>
#include <lamap_mrpt/options/option_table.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/math/TBoundingBox.h>
#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/poses/CPose3DPDF.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/system/COutputLogger.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace lamap
{
class EndPointLikelihood;
struct EndPoints;
class OccupiedCells;
struct ObservedBox;

/** What every learned occupancy map of this library gives, whatever its learner.
 *
 * A learner implements learnScan(), the estimates, its options and its serialization; what MRPT asks of a
 * map follows from these here: likelihood, matching, ray casting, views and files.
 *
 * Thread guarantee: const methods may be called from several threads as long as nobody changes the map.
 */
class CLearnedMap : public mrpt::maps::CMetricMap, public NearestCells, public mrpt::system::COutputLogger
{
 public:
  /// Edge of a finest cell [m].
  [[nodiscard]] virtual double resolution() const = 0;

  /// What the map says at a point of the map frame [m]; nothing where no evidence reaches.
  [[nodiscard]] virtual std::optional<CellEstimate> estimateAt(
      const mrpt::math::TPoint3D& point_map) const = 0;

  using CellVisitor = std::function<void(const CellIndex&, const CellEstimate&)>;
  /// Calls the visitor once for every finest cell that has evidence, pruned ones expanded; no order is
  /// promised.
  virtual void visitCells(const CellVisitor& visitor) const = 0;

  /// Names of CellEstimate::evidence, in its order; one or two.
  [[nodiscard]] virtual std::vector<std::string> evidenceNames() const = 0;

  /// The short name in .ini files, e.g. "bgkMap".
  [[nodiscard]] virtual std::string alias() const = 0;

  /// Facts about the map for a report: (name, value as text, unit or "").
  struct Fact
  {
    std::string name;
    std::string value;
    std::string unit;
  };
  [[nodiscard]] virtual std::vector<Fact> facts() const = 0;

  /// What the map holds in memory [bytes], with all indices, without what only speeds up the next scan.
  [[nodiscard]] virtual size_t memoryBytes() const = 0;

  /// How many threads an insertion may use; 0 (the default): as many as the machine has. Never changes a
  /// result.
  void setThreadCount(unsigned threads) { threadCount_ = threads; }
  [[nodiscard]] unsigned threadCount() const { return threadCount_; }

  /// What else is known of where a scan was taken.
  struct ScanPose
  {
    /// The sensor's frame in the map; nothing: at the origin of the rays, with the map's axes.
    std::optional<mrpt::poses::CPose3D> sensor_map;
    /// Pose of the robot in the map and its covariance; nothing: the pose is certain.
    std::optional<mrpt::poses::CPose3DPDFGaussian> robot_map;
  };

  /** Adds one scan whose rays are given in the map frame.
   * @return false if no ray of it was usable.
   * @throws std::invalid_argument if the insertion options are illegal. */
  bool insertScan(const Scan& scan, const ScanPose& pose = {});

  /** As insertObservation(), at a pose that is not certain. Learners that take uncertain inputs use its
   * covariance as their options say; the others its mean alone. */
  bool insertObservationAt(const mrpt::obs::CObservation& observation,
                           const mrpt::poses::CPose3DPDF& robotPose_map);

  // ---- More that a learner gives
  // -----------------------------------------------------------------------------------

  /// What the map says of a cell; nothing where it has no evidence.
  [[nodiscard]] virtual std::optional<CellEstimate> estimateCell(const CellIndex& cell) const;

  /// The one layer of cells of a map for 2D sensors, whatever the height of a point; nothing for a map in 3D.
  [[nodiscard]] virtual std::optional<int32_t> planarLayer() const { return std::nullopt; }

  /// What makes a cell free or occupied, as the insertion options say now.
  [[nodiscard]] virtual StateThresholds stateThresholds() const = 0;

  /// Which rays the insertion options say are used now.
  [[nodiscard]] virtual RangeLimits rangeLimits() const = 0;

  /** Tells the map that a cell is occupied or free, as one hit or one free point at its centre would.
   * @throws std::invalid_argument if the point is beyond what cells can address. */
  virtual void updateVoxel(double x, double y, double z, bool occupied) = 0;

  /** Calls the visitor for creationOpts, insertOpts, likelihoodOpts and renderOpts: as they hold for this
   * map, lengths in cells resolved, and a new group of the same class, which the visitor may change. */
  using VisitGroup = std::function<void(const TOptionGroup& now, TOptionGroup& untouched)>;
  virtual void visitOptionGroups(const VisitGroup& visit) const = 0;

  /// Every option of every group as text.
  [[nodiscard]] std::vector<OptionValue> optionValues() const;

  /** Whether an option already is what a text says, e.g. "30" and "3e1" are the same.
   * @param section "insertOpts", @param key "maxRange", in which case does not matter.
   * @throws std::invalid_argument if there is no such option (naming the nearest) or the text is not legal.
   */
  [[nodiscard]] bool optionIs(const std::string& section, const std::string& key,
                              const std::string& text) const;

  // ---- Options
  // -----------------------------------------------------------------------------------------------------

  /** How well an observation fits the map at a pose, for particle filters: see end_point_likelihood.h. */
  struct TLikelihoodOptions : public TOptionGroup
  {
    uint32_t decimation = 5;   ///< only every so many-th ray is looked at
    double outlierProb = 0.3;  ///< share of returns that tell nothing: half of it is the least one counts
    double endPointStd = 0.2;  ///< [m] uncertainty of where a return ends; 0: only the cell it ends in counts
    double unobservedProb = 0.25;  ///< P(occupied) that counts for a return where the map has no evidence
    double independence = 0.15;    ///< how much of a return counts as independent of the others

    [[nodiscard]] const OptionTable& optionTable() const override;
    /// As sameOptions(), for every single likelihood.
    friend bool operator==(const TLikelihoodOptions& a, const TLikelihoodOptions& b);
  };
  TLikelihoodOptions likelihoodOptions;

  /// What the cubes of a view are coloured by.
  enum class ColourBy
  {
    Height,
    Probability,
    Variance
  };

  /// How the map becomes a COctoMapVoxels.
  struct TRenderingOptions : public TOptionGroup
  {
    bool generateOccupiedVoxels = true;
    bool visibleOccupiedVoxels = true;
    bool generateFreeVoxels = false;
    bool visibleFreeVoxels = true;
    bool generateGridLines = false;  ///< a wire box around the map's observed cells
    bool hideBuriedVoxels = true;    ///< leave out occupied cells that no side can be seen of
    ColourBy colourBy = ColourBy::Height;
    double freeOpacity = 0.1;

    [[nodiscard]] const OptionTable& optionTable() const override;
  };
  TRenderingOptions renderingOptions;

  // ---- As COctoMap
  // -------------------------------------------------------------------------------------------------

  /// P(occupied) at a point [m]. @return false, leaving prob alone, where the map has no evidence.
  bool getPointOccupancy(float x, float y, float z, double& prob) const;

  /** Follows a ray from cell to cell to the first occupied one.
   * @param direction of any length > 0. @param end centre of that cell, otherwise of the last one looked at.
   * @param ignoreUnknownCells if false, a cell without evidence ends the ray; one that is undecided does not,
   *        as there are always some before a wall.
   * @param maxRange [m], cells that the ray enters farther away are not looked at; <= 0: no limit.
   * @return whether an occupied cell was met; that of the origin counts. */
  bool castRay(const mrpt::math::TPoint3D& origin, const mrpt::math::TPoint3D& direction,
               mrpt::math::TPoint3D& end, bool ignoreUnknownCells = false, double maxRange = -1.0) const;

  /// Adds one ray with a return at its end [m].
  void insertRay(float end_x, float end_y, float end_z, float sensor_x, float sensor_y, float sensor_z);
  /// Adds a scan: points in the map frame, and where their rays came from [m].
  void insertPointCloud(const mrpt::maps::CPointsMap& points, float sensor_x, float sensor_y, float sensor_z);

  /// The map as cubes; see TRenderingOptions.
  void getAsOctoMapVoxels(mrpt::opengl::COctoMapVoxels& voxels) const;

  // ---- CMetricMap
  // --------------------------------------------------------------------------------------------------

  void getVisualizationInto(mrpt::opengl::CSetOfObjects& scene) const override;

  /** Writes prefix.lamap.gz, prefix.3Dscene and prefix.ply (occupied cells), each whole or not at all.
   * @throws std::runtime_error naming the file and the reason. */
  void saveMetricMapRepresentationToFile(const std::string& prefix) const override;

  /// One paragraph for people.
  std::string asString() const override;

  /** Centres of the occupied cells in the order of z, y, x. Belongs to the map, until the map or its
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
  /// Share of the other map's points that have an occupied cell near; 0 if it has no points.
  float compute3DMatchingRatio(const mrpt::maps::CMetricMap* otherMap,
                               const mrpt::poses::CPose3D& otherMapPose,
                               const mrpt::maps::TMatchingRatioParams& params) const override;
  /// In the plane, to the nearest centre of an occupied cell [m²]; the largest float if there is none.
  float squareDistanceToClosestCorrespondence(float x0, float y0) const override;

  /// Of all cells with evidence [m]; MRPT's empty box if there is none.
  mrpt::math::TBoundingBoxf boundingBox() const LAMAP_OVERRIDE_SINCE_2_11_3;

  void auxParticleFilterCleanUp() override;

 protected:
  CLearnedMap() = default;
  /// Observers of the other map do not watch the copy; what was derived from the other's cells is not copied.
  CLearnedMap(const CLearnedMap& other);
  CLearnedMap& operator=(const CLearnedMap& other);

  /// Learns a scan. @return what became of its rays
  virtual RayCounts learnScan(const Scan& scan, const ScanPose& pose) = 0;

  /// To be called after every change of cells.
  void contentChanged();

  /// The cell at a point [m]. @throws std::invalid_argument naming the caller and the point if there is none
  [[nodiscard]] CellIndex addressableCell(const char* caller, double x, double y, double z) const;

  /// How many cells there are of each state. @param also called for each cell on the way
  [[nodiscard]] std::vector<Fact> cellFacts(const CellVisitor& also = {}) const;
  [[nodiscard]] Fact memoryFact() const;
  /// What became of the scans of this session.
  [[nodiscard]] std::vector<Fact> scanFacts() const;

  void OnPostSuccesfulInsertObs(const mrpt::obs::CObservation&) override { contentChanged(); }

 private:
  bool internal_insertObservation(
      const mrpt::obs::CObservation& observation,
      const std::optional<const mrpt::poses::CPose3D>& robotPose = std::nullopt) override;
  double internal_computeObservationLikelihood(const mrpt::obs::CObservation& observation,
                                               const mrpt::poses::CPose3D& takenFrom) const override;
  bool internal_canComputeObservationLikelihood(const mrpt::obs::CObservation& observation) const override;

  std::shared_ptr<const mrpt::maps::CSimplePointsMap> cellsToSearch(bool plane) const override;
  /// Counts what became of a scan's rays, and tells once of each kind that is left out. @return whether any
  /// was used.
  bool tally(const RayCounts& counts);
  [[nodiscard]] std::shared_ptr<const OccupiedCells> occupiedCells() const;
  [[nodiscard]] std::shared_ptr<const ObservedBox> observedBox() const;

  unsigned threadCount_ = 0;
  /// Of the observation being inserted, while it is.
  std::optional<mrpt::poses::CPose3DPDFGaussian> uncertainPose_;
  RayCounts tallied_;
  size_t scansUsed_ = 0;
  size_t scansUnreadable_ = 0;
  Lazy<EndPoints> endPoints_;
  Lazy<EndPointLikelihood> likelihood_;
  Lazy<OccupiedCells> occupied_;
  Lazy<ObservedBox> box_;
};

}  // namespace lamap
