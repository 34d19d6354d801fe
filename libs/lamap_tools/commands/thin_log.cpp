#include <lamap_tools/commands/thin_log.h>

#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/inputs/rawlog_file.h>
#include <lamap_tools/inputs/simple_map_file.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDF.h>
#include <mrpt/serialization/CArchive.h>

#include <filesystem>
#include <ostream>
#include <stdexcept>
#include <vector>

namespace lamap::tools
{
namespace
{
using mrpt::obs::CObservation;
using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservationPointCloud;
using mrpt::obs::CSensoryFrame;

CObservation::Ptr thinnedScan(const CObservation2DRangeScan& scan, size_t every)
{
  auto result = std::make_shared<CObservation2DRangeScan>(scan);
  const size_t count = scan.getScanSize();
  if (count < 2) return result;
  const size_t last = (count - 1) / every;  // number of the last ray that is kept
  const size_t first = (count - 1 - last * every) / 2;
  result->resizeScan(last + 1);
  result->setScanHasIntensity(scan.hasIntensity());
  for (size_t i = 0; i <= last; ++i)
  {
    const size_t from = first + i * every;
    result->setScanRange(i, scan.getScanRange(from));
    result->setScanRangeValidity(i, scan.getScanRangeValidity(from));
    if (scan.hasIntensity()) result->setScanIntensity(i, scan.getScanIntensity(from));
  }
  const double step_rad = static_cast<double>(scan.aperture) / static_cast<double>(count - 1);
  result->aperture = static_cast<float>(step_rad * static_cast<double>(last * every));
  // The middle of the rays that are kept, in steps from the middle of all.
  const double middle = static_cast<double>(first) + 0.5 * static_cast<double>(last * every) -
                        0.5 * static_cast<double>(count - 1);
  const double turn_rad = (scan.rightToLeft ? 1 : -1) * middle * step_rad;
  result->sensorPose = scan.sensorPose + mrpt::poses::CPose3D(0, 0, 0, turn_rad, 0, 0);
  return result;
}

CObservation::Ptr thinnedCloud(const CObservationPointCloud& cloud, size_t every)
{
  cloud.load();
  auto result = std::make_shared<CObservationPointCloud>(cloud);
  result->overrideExternalStorageFormatFlag(CObservationPointCloud::ExternalStorageFormat::None);
  if (!cloud.pointcloud) return result;
  result->pointcloud =
      std::dynamic_pointer_cast<mrpt::maps::CPointsMap>(cloud.pointcloud->duplicateGetSmartPtr());
  std::vector<bool> dropped(cloud.pointcloud->size(), true);
  for (size_t i = 0; i < dropped.size(); i += every) dropped[i] = false;
  result->pointcloud->applyDeletionMask(dropped);
  return result;
}

/// ".simplemap" also for ".simplemap.gz".
std::string kindOf(const std::string& path)
{
  for (const char* kind : {".rawlog", ".simplemap"})
    if (endsWith(path, kind) || endsWith(path, kind + std::string(".gz"))) return kind;
  throw UsageError(path + ": expected a .rawlog, .simplemap or .simplemap.gz");
}

bool isOdometry(const CObservation& observation)
{
  return IS_CLASS(observation, mrpt::obs::CObservationOdometry);
}

void includeAll(const CSensoryFrame& frame, LogContents& contents)
{
  for (const CObservation::Ptr& observation : frame)
    if (!isOdometry(*observation)) contents.include(*observation);
}

LogContents contentsOf(RawlogFile&& log)
{
  LogContents contents;
  while (const auto entry = log.next())
  {
    const auto* observation = dynamic_cast<const CObservation*>(entry.get());
    if (observation && !isOdometry(*observation)) contents.include(*observation);
    if (const auto* frame = dynamic_cast<const CSensoryFrame*>(entry.get())) includeAll(*frame, contents);
  }
  return contents;
}

/// Thins observations and counts them.
class Thinner
{
 public:
  Thinner(const ThinOptions& options, ThinReport& report)
      : every_(options.every), chooser_(options.choice), choosesAll_(options.choice.isAll()), report_(report)
  {
  }

  [[nodiscard]] bool choosesAll() const { return choosesAll_; }

  /// Of the log that is thinned, unless all of it is chosen.
  void setContents(LogContents contents, const std::string& path)
  {
    contents_ = std::move(contents);
    chooser_.requireSensors({contents_}, path);
  }

  /// @return null if it is not chosen
  [[nodiscard]] CObservation::Ptr operator()(const CObservation::Ptr& observation)
  {
    if (!choosesAll_ && !isOdometry(*observation) && !chooser_.takes(*observation, contents_)) return nullptr;
    const std::string name = observation->GetRuntimeClass()->className;
    const auto fewer = every_ == 1 ? std::nullopt : thinned(*observation, every_);
    ++(fewer ? report_.thinned : report_.asTheyAre)[name];
    return fewer.value_or(observation);
  }

  [[nodiscard]] CSensoryFrame::Ptr operator()(const CSensoryFrame& frame)
  {
    auto result = CSensoryFrame::Create();
    for (const CObservation::Ptr& observation : frame)
      if (const auto kept = (*this)(observation)) result->insert(kept);
    return result;
  }

  /// After the last observation. @throws std::runtime_error if there were some, but none was chosen
  void finish(const std::string& path)
  {
    if (choosesAll_) return;
    chooser_.requireTaken(path);
    report_.choice = chooser_.summary();
  }

 private:
  size_t every_;
  ScanChooser chooser_;
  bool choosesAll_;
  LogContents contents_;
  ThinReport& report_;
};

class Output
{
 public:
  explicit Output(const std::string& path) : file_(path)
  {
    if (!stream_.open(file_.temporaryPath())) throw std::runtime_error(path + ": cannot be written");
  }
  void write(const mrpt::serialization::CSerializable& object)
  {
    mrpt::serialization::archiveFrom(stream_) << object;
  }
  void commit()
  {
    stream_.close();
    file_.commit();
  }

 private:
  AtomicFile file_;
  mrpt::io::CFileGZOutputStream stream_;
};

void thinSimpleMap(const ThinOptions& options, const ProgressSink& progress, Thinner& thin,
                   ThinReport& report)
{
  Output out(options.outPath);
  const mrpt::maps::CSimpleMap map = readSimpleMap(options.inPath, options.shouldStop);
  if (!thin.choosesAll())
  {
    LogContents contents;
    for (size_t i = 0; i < map.size(); ++i) includeAll(*compat::keyframeAt(map, i).frame, contents);
    thin.setContents(std::move(contents), options.inPath);
  }
  mrpt::maps::CSimpleMap result;
  for (size_t i = 0; i < map.size() && !(report.stopped = options.shouldStop()); ++i)
  {
    const auto keyframe = compat::keyframeAt(map, i);
    const auto pose =
        std::dynamic_pointer_cast<mrpt::poses::CPose3DPDF>(keyframe.pose->duplicateGetSmartPtr());
    const auto frame = thin(*keyframe.frame);
    if (!frame->empty() || keyframe.frame->empty()) result.insert(pose, frame);
    if (progress) progress({i + 1, map.size(), options.inPath});
  }
  report.stopped = options.shouldStop();
  if (report.stopped) return;
  thin.finish(options.inPath);
  out.write(result);
  out.commit();
  report.saved = true;
}

void thinRawlog(const ThinOptions& options, const ProgressSink& progress, Thinner& thin, ThinReport& report)
{
  Output out(options.outPath);
  const auto readAll = [](RawlogFile& log)
  {
    while (log.next())
    {
    }
    return std::vector<uint8_t>();
  };
  const auto trial = RawlogFile::tryReading(options.inPath, readAll, options.shouldStop);
  if (!thin.choosesAll() && !trial.stopped)
    thin.setContents(contentsOf(RawlogFile(options.inPath, trial.limit)), options.inPath);
  RawlogFile file(options.inPath, trial.limit);
  size_t entries = 0;
  while (!(report.stopped = options.shouldStop()))
  {
    const auto entry = file.next();
    if (!entry) break;
    if (const auto frame = std::dynamic_pointer_cast<CSensoryFrame>(entry))
      out.write(*thin(*frame));
    else if (const auto observation = std::dynamic_pointer_cast<CObservation>(entry))
    {
      if (const auto kept = thin(observation)) out.write(*kept);
    }
    else
      out.write(*entry);
    ++entries;
    if (progress) progress({entries, 0, options.inPath});
  }
  if (report.stopped) return;
  report.damage = file.damage();
  if (entries == 0) throw std::runtime_error(options.inPath + ": holds no entries; nothing is written");
  thin.finish(options.inPath);
  out.commit();
  report.saved = true;
}
}  // namespace

std::optional<CObservation::Ptr> thinned(const CObservation& observation, size_t every)
{
  if (every < 1) throw UsageError("every 0th ray: must be a whole number >= 1");
  if (const auto* scan = dynamic_cast<const CObservation2DRangeScan*>(&observation))
    return thinnedScan(*scan, every);
  if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&observation))
    return thinnedCloud(*cloud, every);
  const std::string name = observation.GetRuntimeClass()->className;
  // A single ray has no others to be thinned out.
  if (supportsObservation(observation) && name != "mrpt::obs::CObservationRange")
    throw std::runtime_error("a " + name +
                             " cannot be thinned; CObservation2DRangeScan and CObservationPointCloud can");
  return std::nullopt;
}

ThinReport thinLog(const ThinOptions& options, const ProgressSink& progress)
{
  if (options.every < 1) throw UsageError("--keep-every 0: must be a whole number >= 1");
  const std::string kind = kindOf(options.inPath);
  if (kindOf(options.outPath) != kind)
    throw UsageError(options.outPath + ": must be of the input's kind, a " + kind);
  if (!std::filesystem::exists(options.inPath)) throw std::runtime_error(options.inPath + ": does not exist");
  ThinReport report;
  Thinner thin(options, report);
  try
  {
    if (kind == ".rawlog")
      thinRawlog(options, progress, thin, report);
    else
      thinSimpleMap(options, progress, thin, report);
  }
  catch (const std::runtime_error& error)
  {
    const std::string what = compat::messageOf(error);
    const bool namesFile =
        what.find(options.inPath) != std::string::npos || what.find(options.outPath) != std::string::npos;
    throw std::runtime_error(namesFile ? what : options.inPath + ": " + what);
  }
  return report;
}

void printReport(const ThinReport& report, const ThinOptions& options, std::ostream& out)
{
  if (!report.choice.empty()) out << "  " << report.choice << "\n";
  for (const auto& [name, count] : report.thinned)
    out << "  one ray in " << options.every << " of " << count << " " << name << "\n";
  for (const auto& [name, count] : report.asTheyAre) out << "  as they are: " << count << " " << name << "\n";
  out << (report.saved ? "saved to " + options.outPath : std::string("nothing is saved")) << "\n";
}

}  // namespace lamap::tools
