#include <lamap_mrpt/files/overlapping_map_content.h>

#include <lamap_mrpt/files/content_parts.h>
#include <lamap_mrpt/files/grid_content.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace lamap
{
namespace
{

void writePose(const ModelPose& pose, ByteWriter& out)
{
  writeIndex(pose.anchor, out);
  writeMatrix(pose.offset_m, out);
  writeMatrix(pose.rotation, out);
}

ModelPose readPose(ByteReader& in)
{
  ModelPose pose;
  pose.anchor = readIndex<CellIndex>(in);
  pose.offset_m = readMatrix<Eigen::Vector3d>(in);
  pose.rotation = readMatrix<Eigen::Matrix3d>(in);
  return pose;
}

void writeView(const DepthView& view, ByteWriter& out)
{
  const DepthView::Image& image = view.image();
  writeMatrix(image.sensor, out);
  for (const double number :
       {image.rangeMax_m, image.rules.near_m, image.rules.depth_m, image.rules.angle_deg})
    out.number(number);
  out.number(image.planar);
  for (const uint32_t number : {image.firstRow, image.firstColumn, image.rows, image.columns})
    out.number(number);
  out.vector(image.depths_m);
  out.vector(image.openShares);
}

DepthView readView(ByteReader& in, uint8_t version)
{
  DepthView::Image image;
  image.sensor = readMatrix<Eigen::Vector3d>(in);
  for (double* number :
       {&image.rangeMax_m, &image.rules.near_m, &image.rules.depth_m, &image.rules.angle_deg})
    *number = in.number<double>();
  image.planar = in.number<bool>();
  for (uint32_t* number : {&image.firstRow, &image.firstColumn, &image.rows, &image.columns})
    *number = in.number<uint32_t>();
  image.depths_m = in.vector<float>();
  constexpr uint8_t kAll = 255;  // version 1: as far as the longest ray
  if (version > 1)
    image.openShares = in.vector<uint8_t>();
  else
    image.openShares.assign(image.depths_m.size() * image.partsOfBin(), kAll);
  return DepthView::fromImage(std::move(image));
}

void writeModel(const HilbertModel& model, ByteWriter& out)
{
  writeAll(model.sites.blocks, out, [&](const BlockIndex& block) { writeIndex(block, out); });
  writeAll(model.sites.bits, out, [&](const SiteSet::Bits& bits) { out.numbers(bits.data(), bits.size()); });
  out.vector(model.sites.weights);
  writeAll(model.inducing, out, [&](const Eigen::Vector3d& place) { writeMatrix(place, out); });
  out.vector(model.kernelWeights);
  out.number(model.bias);
  writeMatrix(model.boxLow, out);
  writeMatrix(model.boxHigh, out);
  writeAll(model.views, out, [&](const DepthView& view) { writeView(view, out); });
  writeAll(model.hits, out, [&](const Eigen::Vector3f& hit) { writeMatrix(hit, out); });
  out.number(model.fieldWeight);
  out.number(model.scans);
  out.number(model.variance);
}

std::shared_ptr<const HilbertModel> readModel(ByteReader& in, uint8_t version)
{
  auto model = std::make_shared<HilbertModel>();
  readAll(model->sites.blocks, kIndexBytes, in, [&] { return readIndex<BlockIndex>(in); });
  readAll(model->sites.bits, sizeof(SiteSet::Bits), in,
          [&]
          {
            SiteSet::Bits bits;
            in.numbers(bits.data(), bits.size());
            return bits;
          });
  model->sites.weights = in.vector<float>();
  model->sites.number();
  readAll(model->inducing, kPlaceBytes, in, [&] { return readMatrix<Eigen::Vector3d>(in); });
  model->kernelWeights = in.vector<float>();
  model->bias = in.number<float>();
  model->boxLow = readMatrix<Eigen::Vector3d>(in);
  model->boxHigh = readMatrix<Eigen::Vector3d>(in);
  readAll(model->views, kPlaceBytes, in, [&] { return readView(in, version); });
  if (version > 1)
    readAll(model->hits, 3 * sizeof(float), in, [&] { return readMatrix<Eigen::Vector3f>(in); });
  model->fieldWeight = in.number<double>();
  model->scans = in.number<uint32_t>();
  if (version > 3) model->variance = in.number<double>();
  return model;
}

/// The rays with a return and the ranks of their echoes, or the others and whether they met anything.
void writeRays(const RayFan& fan, bool returned, ByteWriter& out)
{
  std::vector<Eigen::Vector3d> ends;
  std::vector<uint8_t> kinds;
  for (const Ray& ray : fan.rays)
  {
    if ((ray.meaning == RayEnd::Return) != returned) continue;
    ends.push_back(ray.end);
    kinds.push_back(returned ? ray.echo : static_cast<uint8_t>(ray.meaning == RayEnd::Cut));
  }
  writeAll(ends, out, [&](const Eigen::Vector3d& end) { writeMatrix(end, out); });
  out.vector(kinds);
}

void readRays(RayFan& fan, bool returned, size_t& count, ByteReader& in, uint8_t version)
{
  std::vector<Eigen::Vector3d> ends;
  readAll(ends, kPlaceBytes, in, [&] { return readMatrix<Eigen::Vector3d>(in); });
  std::vector<uint8_t> kinds(ends.size(), returned ? 0 : 1);
  if (version > 2) kinds = in.vector<uint8_t>();
  if (kinds.size() != ends.size())
    throw std::runtime_error("the map is corrupt: not every ray of a waiting scan has a kind");
  for (size_t i = 0; i < ends.size(); ++i)
  {
    if (returned)
      fan.rays.push_back({ends[i], RayEnd::Return, kinds[i]});
    else
      fan.add(kinds[i] != 0 ? RayEnd::Cut : RayEnd::NoReturn, ends[i]);
  }
  count += ends.size();
}

void writeScan(const ModelScan& scan, ByteWriter& out)
{
  writeAll(
      scan.rays.scan.fans, out,
      [&](const RayFan& fan)
      {
        writeMatrix(fan.centre, out);
        out.number(fan.beam.halfWidth_rad);
        out.number(fan.beam.halfHeight_rad);
        out.number(fan.beam.rangeStd_m);
        writeMatrix(fan.beam.up, out);
        writeRays(fan, true, out);
        writeRays(fan, false, out);
        out.number(fan.statedRangeMax_m > 0 ? fan.statedRangeMax_m : std::numeric_limits<double>::infinity());
      });
  out.number(scan.uncertainty.has_value());
  if (!scan.uncertainty) return;
  writeMatrix(scan.uncertainty->pose, out);
  writeMatrix(scan.uncertainty->centre, out);
  out.number(scan.uncertainty->rangeStd_m);
  writeMatrix(scan.uncertainty->point, out);
}

Beam readBeam(ByteReader& in, uint8_t version)
{
  Beam beam;
  beam.halfWidth_rad = in.number<double>();
  beam.halfHeight_rad = in.number<double>();
  beam.rangeStd_m = in.number<double>();
  if (version > 2) beam.up = readMatrix<Eigen::Vector3d>(in);
  return beam;
}

ModelScan readScan(ByteReader& in, uint8_t version)
{
  ModelScan scan;
  readAll(scan.rays.scan.fans, kPlaceBytes + 2 * sizeof(uint64_t) + sizeof(double), in,
          [&]
          {
            RayFan fan;
            fan.centre = readMatrix<Eigen::Vector3d>(in);
            if (version > 1) fan.beam = readBeam(in, version);
            readRays(fan, true, scan.rays.counts.hits, in, version);
            readRays(fan, false, scan.rays.counts.freeOnly, in, version);
            const auto rangeMax_m = in.number<double>();
            fan.statedRangeMax_m = rangeMax_m == std::numeric_limits<double>::infinity() ? 0 : rangeMax_m;
            return fan;
          });
  if (!in.number<bool>()) return scan;
  HilbertUncertainty& uncertainty = scan.uncertainty.emplace();
  uncertainty.pose = readMatrix<Eigen::Matrix<double, 6, 6>>(in);
  uncertainty.centre = readMatrix<Eigen::Vector3d>(in);
  uncertainty.rangeStd_m = in.number<double>();
  uncertainty.point = readMatrix<Eigen::Matrix3d>(in);
  return scan;
}
}  // namespace

void writeOverlappingMap(const OverlappingHilbertMap& map, ByteWriter& out)
{
  writeGrid(map.evidence(), out);
  writeGrid(map.writtenEvidence(), out);
  writeAll(map.models(), out,
           [&](const PlacedModel& placed)
           {
             writePose(placed.pose, out);
             writeModel(*placed.model, out);
           });
  writePose(map.pending().pose, out);
  writeAll(map.pending().scans, out, [&](const ModelScan& scan) { writeScan(scan, out); });
}

void readOverlappingMap(OverlappingHilbertMap& map, ByteReader& in, uint8_t version)
{
  const auto layer = map.structure().planar ? std::optional(map.planarLayer()) : std::nullopt;
  Evidence evidence = readGrid(map.evidence(), layer, in);
  map.restoreEvidence(std::move(evidence), readGrid(map.writtenEvidence(), layer, in));
  std::vector<PlacedModel> models;
  constexpr size_t kPoseBytes = kIndexBytes + 12 * sizeof(double);
  readAll(models, kPoseBytes, in,
          [&]
          {
            PlacedModel placed;
            placed.pose = readPose(in);
            placed.model = readModel(in, version);
            return placed;
          });
  PendingScans pending;
  pending.pose = readPose(in);
  readAll(pending.scans, sizeof(uint64_t), in, [&] { return readScan(in, version); });
  try
  {
    map.restore(std::move(models), std::move(pending));
  }
  catch (const std::exception& error)
  {
    in.fail(error.what());
  }
}

}  // namespace lamap
