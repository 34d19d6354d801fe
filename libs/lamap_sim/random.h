#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace lamap::sim
{
/// Sine and cosine of an angle [rad] with |angle| < 1e5, error below 1e-15. Unlike those of the C library,
/// they have the same bits on every processor.
struct SineCosine
{
  double sine = 0;
  double cosine = 1;
};
[[nodiscard]] SineCosine sineCosine(double angle_rad);

/** Random numbers that depend only on the seed and the stream: not on the processor, and not on the C++
 * library, whose distributions are unspecified. An object must be used by one thread only. */
class Random
{
 public:
  /// Streams of one seed are independent: drawing from one does not change the others.
  explicit Random(uint64_t seed, uint64_t stream = 0);

  /// In [low, high).
  [[nodiscard]] double uniform(double low, double high);
  /// In [low, high].
  [[nodiscard]] int integer(int low, int high);
  /// @param prob  in [0, 1]
  [[nodiscard]] bool chance(double prob) { return uniform(0, 1) < prob; }
  /// Gaussian with mean 0 and standard deviation 1 (Box and Muller).
  [[nodiscard]] double normal();
  /// Three independent normal() numbers.
  [[nodiscard]] Eigen::Vector3d normal3();

 private:
  std::mt19937_64 engine_;
};

}  // namespace lamap::sim
