#include <lamap_core/options/legal_range.h>
#include <lamap_core/scan/echo_detection.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
namespace
{
/// Whether bin i is the first of a run of equal ones that is higher than the bins on both sides.
bool isPeak(const std::vector<double>& intensities, size_t i)
{
  const double height = intensities[i];
  if (i > 0 && intensities[i - 1] >= height) return false;
  size_t next = i + 1;
  while (next < intensities.size() && intensities[next] == height) ++next;
  return next == intensities.size() || !(intensities[next] > height);
}
}  // namespace

void EchoRules::validate() const
{
  requireLegal(std::isfinite(nearThreshold), "threshold near the sensor", nearThreshold, "a finite number");
  requireLegal(std::isfinite(farThreshold), "threshold at the maximum range", farThreshold,
               "a finite number");
  requireLegal(deadZone_m >= 0 && std::isfinite(deadZone_m), "dead zone", deadZone_m, "a finite length >= 0");
  requireLegal(separation_m >= 0 && std::isfinite(separation_m), "separation of echoes", separation_m,
               "a finite length >= 0");
  requireLegal(mostEchoes >= 1, "number of echoes", static_cast<double>(mostEchoes), "at least 1");
}

std::vector<DetectedEcho> findEchoes(const std::vector<double>& intensities, double rangeMax_m,
                                     const EchoRules& rules)
{
  std::vector<DetectedEcho> peaks;
  const auto count = static_cast<double>(intensities.size());
  for (size_t i = 0; i < intensities.size(); ++i)
  {
    const double share = (static_cast<double>(i) + 0.5) / count;
    const double threshold = rules.nearThreshold + share * (rules.farThreshold - rules.nearThreshold);
    const double range_m = share * rangeMax_m;
    if (range_m >= rules.deadZone_m && intensities[i] >= threshold && isPeak(intensities, i))
      peaks.push_back({range_m, intensities[i]});
  }
  // The strongest first; of equals, the nearest.
  std::stable_sort(peaks.begin(), peaks.end(),
                   [](const DetectedEcho& a, const DetectedEcho& b) { return a.intensity > b.intensity; });
  std::vector<DetectedEcho> echoes;
  for (const DetectedEcho& peak : peaks)
  {
    const auto isClose = [&](const DetectedEcho& echo)
    { return std::abs(echo.range_m - peak.range_m) < rules.separation_m; };
    if (std::none_of(echoes.begin(), echoes.end(), isClose)) echoes.push_back(peak);
  }
  std::sort(echoes.begin(), echoes.end(),
            [](const DetectedEcho& a, const DetectedEcho& b) { return a.range_m < b.range_m; });
  if (echoes.size() > rules.mostEchoes) echoes.resize(rules.mostEchoes);
  return echoes;
}

}  // namespace lamap
