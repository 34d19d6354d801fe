#pragma once

#include <lamap_tools/inputs/scan_source.h>
#include <lamap_tools/report/progress_bar.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace lamap::tools
{
/// @param source  that the item belongs to
using ScanVisitor = std::function<void(const ScanItem& item, const ScanSource& source)>;

/** Calls the visitor for each item of the inputs in their order, and the sink after each.
 * @return whether it came to the end before it was asked to stop
 * @throws std::runtime_error if a choice (InputOptions::choice) took none of their observations */
bool visitScans(const std::vector<std::unique_ptr<ScanSource>>& sources,
                const std::function<bool()>& shouldStop, const ProgressSink& report,
                const ScanVisitor& visitor);

/// How an input was read.
struct InputReport
{
  std::string path;
  std::vector<std::string> notes;
  std::vector<std::string> damages;  ///< what could not be read
};

/// How each input was read. What was chosen counts as a remark on a single input.
[[nodiscard]] std::vector<InputReport> reportsOf(const std::vector<std::unique_ptr<ScanSource>>& sources);
/// Remarks on several inputs together, which they name: on what was chosen, for one.
[[nodiscard]] std::vector<std::string> jointNotesOf(const std::vector<std::unique_ptr<ScanSource>>& sources);
/// All remarks, those on one input with its name.
[[nodiscard]] std::vector<std::string> allNotesOf(const std::vector<std::unique_ptr<ScanSource>>& sources);
/// Whether any of them could not be read whole.
[[nodiscard]] bool damaged(const std::vector<InputReport>& inputs);

}  // namespace lamap::tools
