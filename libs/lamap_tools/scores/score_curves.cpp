#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/pictures/gnuplot.h>
#include <lamap_tools/report/text_table.h>
#include <lamap_tools/scores/score_report.h>
#include <mrpt/core/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
/// Over which cells a curve is.
struct CellSet
{
  const char* name;
  const char* title;
  Scores MapScores::*scores;
};
constexpr std::array<CellSet, 2> kSets{
    {{"all", "all cells", &MapScores::all}, {"observed", "observed cells", &MapScores::observed}}};

void writeCsv(const std::vector<MapScores>& maps, const std::string& path, const std::string& columns,
              const std::function<void(FileOutput&, const std::string& head, const Scores&)>& writeSet)
{
  FileOutput file(path);
  file.append("map,cells," + columns + "\n");
  for (const MapScores& map : maps)
    for (const CellSet& set : kSets) writeSet(file, csvField(map.name) + "," + set.name, map.*set.scores);
  file.commit();
}

void appendLine(FileOutput& file, const std::string& head, std::initializer_list<double> numbers)
{
  file.append(head);
  for (const double number : numbers)
  {
    file.append(",");
    file.append(number);
  }
  file.append("\n");
}

/// As much of a title as there is room for below a panel; long ones are paths, whose ends tell them apart.
std::string shortened(const std::string& title)
{
  constexpr size_t kMost = 50;
  constexpr size_t kBegin = 16;
  if (title.size() <= kMost) return title;
  return title.substr(0, kBegin) + "..." + title.substr(title.size() - (kMost - kBegin - 3));
}

/// What is drawn of each map.
struct Plot
{
  std::string axes;
  std::string style;
  std::function<std::string(const Scores&)> points;
  std::function<std::string(const MapScores&, const Scores&)> title;
};

/// One of two panels: a curve for each map.
std::string panel(const std::vector<MapScores>& maps, const Plot& plot, const CellSet& set)
{
  std::string blocks, curves;
  for (size_t i = 0; i < maps.size(); ++i)
  {
    const Scores& scores = maps[i].*set.scores;
    const std::string points = plot.points(scores);
    // Where there is no curve the name stands all the same: panels with as many names are equally large.
    const std::string block = "$" + std::string(set.name) + std::to_string(i);
    if (!points.empty()) blocks += block + " << EOD\n" + points + "EOD\n";
    curves += ", " + (points.empty() ? "NaN" : block + " using 1:2") + " with " + plot.style + " lw 2 lc " +
              std::to_string(i + 1) + " title " + gnuplotText(shortened(plot.title(maps[i], scores)));
  }
  return blocks + "set title " + gnuplotText(set.title) +
         "\nset key outside below left Left reverse vertical maxcols 1\n"
         "plot x with lines dt 2 lc rgb '#999999' notitle" +
         curves + "\n";
}

/// Side by side: all cells, observed cells.
void draw(const std::vector<MapScores>& maps, const Plot& plot, const std::string& path)
{
  std::string script =
      "set multiplot layout 1,2\nset size ratio 1\nset grid lt 1 lw 1 lc rgb '#dddddd'\n"
      "set xrange [0:1]\nset yrange [0:1]\n" +
      plot.axes;
  for (const CellSet& set : kSets) script += panel(maps, plot, set);
  // Room for a title per map below the panels.
  drawWithGnuplot(script + "unset multiplot\n", path, 1200, 620 + 22 * static_cast<int>(maps.size()));
}

std::string scoreText(const std::optional<double>& score)
{
  return score ? mrpt::format("%.3f", *score) : "undefined";
}

std::string pointLine(double x, double y)
{
  return shortest(x) + " " + shortest(y) + "\n";
}

std::string rocPoints(const Scores& scores)
{
  std::string points;
  for (const RocPoint& point : scores.roc)
    points += pointLine(point.falsePositiveRate, point.truePositiveRate);
  return points;
}

std::string calibrationPoints(const Scores& scores)
{
  std::string points;
  for (const CalibrationBin& bin : scores.calibration)
    if (bin.cells > 0) points += pointLine(bin.meanProb, bin.occupiedShare);
  return points;
}
}  // namespace

void requireCurveFile(const std::string& path)
{
  const std::string extension = extensionOf(path);
  if (extension != ".csv" && extension != ".png")
    throw UsageError(path + ": curves are written as .csv or .png");
  {
    const AtomicFile placeIsWritable(path);
  }
  if (extension == ".png") requireGnuplot(path);
}

void writeRocCurves(const std::vector<MapScores>& maps, const std::string& path)
{
  const bool any =
      std::any_of(maps.begin(), maps.end(), [](const MapScores& map) { return !map.all.roc.empty(); });
  if (!any)
    throw std::runtime_error(path + ": there is no ROC curve, as the cells are all free or all occupied");
  if (extensionOf(path) == ".csv")
    return writeCsv(
        maps, path, "threshold,false_positive_rate,true_positive_rate",
        [](FileOutput& file, const std::string& head, const Scores& scores)
        {
          for (const RocPoint& point : scores.roc)
            appendLine(file, head, {point.threshold, point.falsePositiveRate, point.truePositiveRate});
        });
  const auto title = [](const MapScores& map, const Scores& scores)
  { return "AUC " + scoreText(scores.areaUnderRoc) + "  " + map.name; };
  draw(maps,
       {"set xlabel 'false positive rate'\nset ylabel 'true positive rate'\n", "lines", rocPoints, title},
       path);
}

void writeCalibration(const std::vector<MapScores>& maps, const std::string& path)
{
  if (extensionOf(path) == ".csv")
    return writeCsv(maps, path, "low,high,count,mean_prob,occupied_share",
                    [](FileOutput& file, const std::string& head, const Scores& scores)
                    {
                      for (const CalibrationBin& bin : scores.calibration)
                      {
                        file.append(head + "," + shortest(bin.low) + "," + shortest(bin.high) + "," +
                                    std::to_string(bin.cells));
                        if (bin.cells > 0)
                          appendLine(file, "", {bin.meanProb, bin.occupiedShare});
                        else
                          file.append(",,\n");
                      }
                    });
  const auto title = [](const MapScores& map, const Scores& scores)
  { return "error " + scoreText(scores.calibrationError) + "  " + map.name; };
  draw(maps,
       {"set xlabel 'P(occupied) as the map says'\nset ylabel 'share of cells that are occupied'\n",
        "linespoints pt 7", calibrationPoints, title},
       path);
}

}  // namespace lamap::tools
