#include <lamap_core/gp/regression.h>

#include <lamap_core/math/portable_math.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace lamap
{
namespace
{
constexpr size_t kTile = std::tuple_size_v<GpTile>;
}  // namespace

GpCovariance::GpCovariance(double lengthScale_cells, double signalVariance, int farthest_cells)
    : factor_(std::sqrt(3.0) / lengthScale_cells), signalVariance_(signalVariance)
{
  if (farthest_cells <= 0) return;
  const auto farthest = static_cast<size_t>(farthest_cells);
  table_.resize(3 * farthest * farthest + 1);
  for (size_t i = 0; i < table_.size(); ++i) table_[i] = (*this)(static_cast<double>(i));
}

double GpCovariance::operator()(double squared_cells) const  // Eq. (2.24)
{
  const double t = factor_ * std::sqrt(squared_cells);
  return signalVariance_ * ((1.0 + t) * portableExp(-t));
}

void GpCovariance::replace(size_t count, GpTile* rows) const
{
  if (table_.empty())
    matern32(factor_, signalVariance_, count, rows);
  else
    lookUp(table_.data(), count, rows);
}

void GpExpert::train(const GpPoint* points, size_t count, const GpCovariance& covariance,
                     double noiseVariance, Scratch& scratch)
{
  x_.resize(count);
  y_.resize(count);
  z_.resize(count);
  noise_.resize(count);
  whitened_.resize(count);
  inverse_.resize(count);
  factor_.resize(count * (count + 1) / 2);
  low_.setConstant(std::numeric_limits<double>::max());
  high_.setConstant(-std::numeric_limits<double>::max());
  for (size_t i = 0; i < count; ++i)
  {
    const Eigen::Vector3d& place = points[i].place;
    x_[i] = place.x();
    y_[i] = place.y();
    z_[i] = place.z();
    whitened_[i] = points[i].label;
    noise_[i] = noiseVariance + points[i].noise;
    low_ = low_.cwiseMin(place);
    high_ = high_.cwiseMax(place);
  }
  // The variance that all points in one place would leave: rounding must not make any prediction more
  // certain.
  const double signal = covariance.signalVariance();
  leastVariance_ = signal * noiseVariance / (static_cast<double>(count) * signal + noiseVariance);
  factorize(covariance, scratch.solved);
  for (size_t i = 0; i < count; ++i)
  {
    double sum = whitened_[i];
    const double* l = row(i);
    for (size_t j = 0; j < i; ++j) sum -= l[j] * whitened_[j];
    whitened_[i] = sum * inverse_[i];
  }
}

/** Cholesky factor of K + σ_n² I, one tile of rows at a time: the part of the rows that depends on earlier
 * rows is the same forward substitution as in a prediction. */
void GpExpert::factorize(const GpCovariance& covariance, std::vector<GpTile>& above)
{
  const size_t count = x_.size();
  above.resize(std::max(above.size(), count));
  for (size_t first = 0; first < count; first += kTile)
  {
    const size_t height = std::min(kTile, count - first);
    GpPlaces places;
    for (size_t c = 0; c < kTile; ++c)
    {
      const size_t i = first + std::min(c, height - 1);
      places.x[c] = x_[i];
      places.y[c] = y_[i];
      places.z[c] = z_[i];
    }
    GpTile nearest;
    squaredDistances(x_.data(), y_.data(), z_.data(), first + height, places, above.data(), nearest);
    covariance.replace(first + height, above.data());
    solveForward(factor_.data(), inverse_.data(), first, above.data());

    // The tile's own square of K, minus the contributions of the rows above.
    std::array<GpTile, kTile> square{};
    for (size_t r = 0; r < height; ++r) square[r] = above[first + r];
    subtractProducts(first, above.data(), square.data());

    for (size_t r = 0; r < height; ++r)
    {
      double* l = row(first + r);
      for (size_t j = 0; j < first; ++j) l[j] = above[j][r];
      for (size_t c = 0; c < r; ++c)
      {
        double sum = square[r][c];
        for (size_t k = 0; k < c; ++k) sum -= l[first + k] * row(first + c)[first + k];
        l[first + c] = sum * inverse_[first + c];
      }
      const double noise = noise_[first + r];
      double pivot = square[r][r] + noise;
      for (size_t k = 0; k < r; ++k) pivot -= l[first + k] * l[first + k];
      // K is positive semidefinite: only rounding could take a pivot below the noise.
      l[first + r] = std::sqrt(std::max(pivot, noise));
      inverse_[first + r] = 1.0 / l[first + r];
    }
  }
}

bool GpExpert::predict(const GpPlaces& places, double squaredReach, const GpCovariance& covariance,
                       Scratch& scratch, Prediction& prediction) const
{
  scratch.solved.resize(std::max(scratch.solved.size(), size()));
  GpTile* rows = scratch.solved.data();
  squaredDistances(x_.data(), y_.data(), z_.data(), size(), places, rows, prediction.nearest);
  if (std::none_of(prediction.nearest.begin(), prediction.nearest.end(),
                   [&](double squared) { return squared < squaredReach; }))
    return false;
  covariance.replace(size(), rows);
  solveForward(factor_.data(), inverse_.data(), size(), rows);
  GpTile explained;
  sumRows(whitened_.data(), size(), rows, prediction.mean, explained);  // Eq. (2.22), (2.23)
  for (size_t c = 0; c < kTile; ++c)
    prediction.variance[c] = std::max(covariance.signalVariance() - explained[c], leastVariance_);
  return true;
}

}  // namespace lamap
