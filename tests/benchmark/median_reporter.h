#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace lamap::test
{
/// Collects the time of every repetition beside the usual output.
class MedianReporter : public benchmark::ConsoleReporter
{
 public:
  void ReportRuns(const std::vector<Run>& runs) override
  {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs)
    {
      if (run.run_type == Run::RT_Iteration)
        times_[run.run_name.function_name].push_back(run.GetAdjustedRealTime());
    }
  }

  /// 0 for a benchmark that was not run.
  [[nodiscard]] double median(const std::string& name) const
  {
    const auto found = times_.find(name);
    if (found == times_.end()) return 0.0;
    std::vector<double> times = found->second;
    std::nth_element(times.begin(), times.begin() + static_cast<long>(times.size() / 2), times.end());
    return times[times.size() / 2];
  }

 private:
  std::map<std::string, std::vector<double>> times_;
};

}  // namespace lamap::test
