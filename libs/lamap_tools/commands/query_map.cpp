#include <lamap_tools/commands/query_map.h>

#include <lamap_tools/files/file_output.h>
#include <mrpt/math/TPoint3D.h>

#include <ostream>
#include <utility>

namespace lamap::tools
{
using mrpt::math::TPoint3D;

void writeAnswersCsv(const CellMap& map, const std::vector<TPoint3D>& points, std::ostream& out)
{
  const auto names = map.evidenceNames();
  out << "x,y,z,prob,variance,state";
  for (const auto& name : names) out << ',' << name;
  out << '\n';
  for (const auto& point : points)
  {
    const auto estimate = map.estimateAt(point);
    out << shortest(point.x) << ',' << shortest(point.y) << ',' << shortest(point.z) << ',';
    if (estimate) out << shortest(estimate->prob);
    out << ',';
    if (estimate && estimate->variance) out << shortest(*estimate->variance);
    out << ',' << (estimate ? stateName(estimate->state) : "unobserved");
    for (size_t i = 0; i < names.size(); ++i) out << ',' << (estimate ? shortest(estimate->evidence[i]) : "");
    out << '\n';
  }
}

Json answersJson(const CellMap& map, const std::vector<TPoint3D>& points)
{
  const auto names = map.evidenceNames();
  Json answers = Json::array();
  for (const auto& point : points)
  {
    const auto estimate = map.estimateAt(point);
    Json answer{{"x", point.x}, {"y", point.y}, {"z", point.z}};
    answer["prob"] = estimate ? Json(estimate->prob) : nullptr;
    answer["variance"] = estimate ? jsonOf(estimate->variance) : nullptr;
    answer["state"] = estimate ? stateName(estimate->state) : "unobserved";
    for (size_t i = 0; i < names.size(); ++i)
      answer[names[i]] = estimate ? Json(estimate->evidence[i]) : nullptr;
    answers.push_back(std::move(answer));
  }
  return answers;
}

}  // namespace lamap::tools
