#pragma once

#include <lamap_core/scan/scan.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace lamap::tools
{
/// Shortest and longest of some lengths [m].
struct LengthSpan
{
  double shortest_m = 0;
  double longest_m = 0;

  void include(const LengthSpan& other);
};

/** What the rays of one scan are.
 *
 * Judged as selectRays() does without options: a return at the sensor itself, or nearer than the observation
 * states, is TooNear; one beyond the stated range is Cut. */
struct ScanLook
{
  /// How many of each RayEnd, in its order; of the returns, those that are finite.
  std::array<uint64_t, 5> rays{};
  uint64_t notFinite = 0;            ///< returns at NaN or infinity
  std::optional<LengthSpan> ranges;  ///< of the finite returns, from the centre of their fan
  /// What the observation states; a maximum of 0: unlimited. Nothing: it states no range.
  std::optional<LengthSpan> statedRanges;
  /// Opening angles of the widest beam, edge to edge [rad]; 0: beams are lines.
  double beamWidth_rad = 0;
  double beamHeight_rad = 0;
  /// Finite returns whose range is the longest one to 0.1 %.
  uint64_t farthestReturns = 0;

  [[nodiscard]] uint64_t count(RayEnd end) const { return rays[static_cast<size_t>(end)]; }
  [[nodiscard]] uint64_t rayCount() const;

  /** Whether it looks as if a driver wrote what lies beyond the useful range as returns at one constant
   * distance: a twentieth of at least 100 returns are at the longest range, and no maximum is stated. */
  [[nodiscard]] bool hasPhantomShell() const;
};

[[nodiscard]] ScanLook lookAt(const Scan& scan);

/// Whether a look at the scan of this number (from 0) of a sensor is worth its time: it is for the first ten
/// and for a twentieth of the others.
[[nodiscard]] bool isWorthALook(size_t number);

/// The phantom shells of a sensor's scans.
class PhantomShells
{
 public:
  void add(const ScanLook& look);
  /// How many of the scans that have returns seem to have a shell.
  [[nodiscard]] size_t count() const { return ranges_m_.size(); }
  /// Range of the nearest shell that at least a quarter of the scans with returns have.
  [[nodiscard]] std::optional<double> nearest_m() const;

 private:
  size_t scans_ = 0;
  std::vector<double> ranges_m_;
};

/// How many of a sensor's scans hold hardly a return: it looked into the open, or it was blinded or dead.
struct EmptyScans
{
  size_t scans = 0;
  size_t empty = 0;        ///< of them, those without a single return, but with rays that had none
  size_t nearlyEmpty = 0;  ///< and those with at least nine rays without return for each return

  /// One scan. @param missing  its rays without return
  void add(uint64_t returns, uint64_t missing);
};

}  // namespace lamap::tools
