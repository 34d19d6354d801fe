#include <lamap_tools/commands/comparison_page.h>

#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/cells/truth_cells.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/pictures/occupied_frame.h>
#include <lamap_tools/pictures/render_map.h>
#include <mrpt/core/format.h>
#include <mrpt/system/string_utils.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace lamap::tools
{
namespace
{
constexpr int kPictureWidth = 900;

/// What the page shows of one map.
struct Exhibit
{
  std::string title;
  std::shared_ptr<const CellMap> cells;
};

std::string htmlText(const std::string& text)
{
  std::string escaped;
  for (const char c : text)
    escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  return escaped;
}

/// Around the occupied cells of all; nothing if there is none.
std::optional<mrpt::math::TBoundingBox> commonBox(const std::vector<Exhibit>& exhibits)
{
  std::optional<mrpt::math::TBoundingBox> box;
  for (const Exhibit& exhibit : exhibits)
  {
    const auto frame = occupiedFrame(*exhibit.cells, [](const CellIndex&) { return true; });
    if (!frame) continue;
    const Eigen::AlignedBox3d box_m = frame->box_m(exhibit.cells->resolution());
    const auto corner = [](const Eigen::Vector3d& p) { return mrpt::math::TPoint3D(p.x(), p.y(), p.z()); };
    const mrpt::math::TBoundingBox own(corner(box_m.min()), corner(box_m.max()));
    box = box ? box->unionWith(own) : own;
  }
  return box;
}

/// A map of one layer says nothing in 3D.
bool isFlat(const std::vector<Exhibit>& exhibits)
{
  return std::all_of(exhibits.begin(), exhibits.end(),
                     [](const Exhibit& exhibit)
                     {
                       const auto extent = cellExtent(*exhibit.cells);
                       return !extent || extent->first.z == extent->last.z;
                     });
}

/// The picture as an element of the page, or why there is none.
std::string pictureOf(const Exhibit& exhibit, const RenderOptions& options, const std::string& pagePath)
{
  try
  {
    const AtomicFile scratch(pagePath + ".png");
    if (!drawMap(*exhibit.cells, options).saveToFile(scratch.temporaryPath()))
      throw std::runtime_error("its picture cannot be written beside " + pagePath);
    std::ifstream file(scratch.temporaryPath(), std::ios::binary);
    const std::vector<uint8_t> png{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    std::string base64;
    mrpt::system::encodeBase64(png, base64);
    base64.erase(std::remove(base64.begin(), base64.end(), '\n'), base64.end());
    return "<img alt=\"" + htmlText(exhibit.title) + "\" src=\"data:image/png;base64," + base64 + "\">";
  }
  catch (const std::runtime_error& error)
  {
    return "<p>No picture: " + htmlText(error.what()) + "</p>";
  }
}

std::string htmlTable(const TextTable& table)
{
  std::string html = "<table>\n";
  bool head = true;
  for (const auto& row : table.rows())
  {
    const std::string tag = head ? "th" : "td";
    html += "<tr>";
    for (const std::string& field : row) html += "<" + tag + ">" + htmlText(field) + "</" + tag + ">";
    html += "</tr>\n";
    head = false;
  }
  return html + "</table>\n";
}

constexpr const char* kHead =
    "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>Maps compared</title>\n"
    "<style>\n"
    "body { font-family: sans-serif; margin: 2em; }\n"
    "table { border-collapse: collapse; margin-bottom: 2em; }\n"
    "th, td { padding: 0.3em 0.8em; border-bottom: 1px solid #ccc; text-align: right; }\n"
    "th:first-child, td:first-child { text-align: left; }\n"
    ".maps { display: grid; grid-template-columns: repeat(auto-fit, minmax(420px, 1fr)); gap: 1.5em; }\n"
    "figure { margin: 0; }\nfigcaption { font-weight: bold; margin-bottom: 0.4em; }\n"
    "img { width: 100%; }\n</style>\n</head>\n<body>\n<h1>Maps compared</h1>\n";
}  // namespace

void writeComparisonPage(const Comparison& comparison, const Truth* truth, const std::string& path)
{
  std::vector<Exhibit> exhibits;
  if (truth != nullptr)
    if (std::shared_ptr<const CellMap> cells = cellsOf(*truth)) exhibits.push_back({"the truth", cells});
  for (const ComparedMap& map : comparison.maps) exhibits.push_back({map.name, map.cells});

  FileOutput page(path);
  page.append(kHead);
  if (!comparison.scoredBy.empty())
    page.append(
        "<p>Scored by " + htmlText(comparison.scoredBy) +
        mrpt::format(". A cell that a map has not observed counts as %g; the calibration error is over "
                     "those it has observed.</p>\n",
                     kUnobservedProb));
  page.append(htmlTable(comparisonTable(comparison, ForWhom::People)));
  for (const std::string& note : comparison.notes) page.append("<p>" + htmlText(note) + "</p>\n");
  RenderOptions options;
  options.width = kPictureWidth;
  options.box_map = commonBox(exhibits);
  std::vector<std::pair<View, const char*>> views{{View::Top, "From above"}};
  if (!isFlat(exhibits)) views.emplace_back(View::Perspective, "In 3D");
  for (const auto& [view, title] : views)
  {
    options.view = view;
    page.append(std::string("<h2>") + title + "</h2>\n<div class=\"maps\">\n");
    for (const Exhibit& exhibit : exhibits)
      page.append("<figure><figcaption>" + htmlText(exhibit.title) + "</figcaption>" +
                  pictureOf(exhibit, options, path) + "</figure>\n");
    page.append("</div>\n");
  }
  page.append("</body>\n</html>\n");
  page.commit();
}

}  // namespace lamap::tools
