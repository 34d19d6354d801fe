#include <lamap_mrpt/files/hilbert_map_content.h>

#include <lamap_core/hilbert/seen_cells.h>
#include <lamap_core/hilbert/state.h>
#include <lamap_mrpt/files/content_parts.h>

#include <algorithm>

namespace lamap
{
namespace
{
constexpr size_t kPosteriorBytes = 2 * sizeof(float);

void writeBlock(const HilbertState::Block& block, ByteWriter& out)
{
  writeIndex(block.index, out);
  out.numbers(block.bits.data(), block.bits.size());
  writeAll(block.weights, out,
           [&](const SitePosterior& weight)
           {
             out.number(weight.mean);
             out.number(weight.precision);
           });
}

HilbertState::Block readBlock(ByteReader& in)
{
  HilbertState::Block block;
  block.index = readIndex<BlockIndex>(in);
  for (uint64_t& word : block.bits) word = in.number<uint64_t>();
  readAll(block.weights, kPosteriorBytes, in,
          [&]
          {
            SitePosterior weight;
            weight.mean = in.number<float>();
            weight.precision = in.number<float>();
            return weight;
          });
  return block;
}

void writeSeen(const HilbertState::SeenBlock& seen, ByteWriter& out)
{
  writeIndex(seen.index, out);
  out.numbers(seen.bits.data(), seen.bits.size());
  out.vector(seen.hits);
  out.vector(seen.passes);
}

HilbertState::SeenBlock readSeen(ByteReader& in, uint8_t version)
{
  HilbertState::SeenBlock seen;
  seen.index = readIndex<BlockIndex>(in);
  for (uint64_t& word : seen.bits) word = in.number<uint64_t>();
  seen.hits = in.vector<uint8_t>();
  if (version > 2)
  {
    seen.passes = in.vector<uint8_t>();
    return seen;
  }
  // Votes: hits less the passes since the first of them.
  for (uint8_t& votes : seen.hits)
    votes = static_cast<uint8_t>(std::min<int>(votes, SeenCells::kScansKept) * SeenCells::kUnits);
  seen.passes.assign(seen.hits.size(), 0);
  return seen;
}

void writeWidths(const HilbertState::WidthBlock& widths, ByteWriter& out)
{
  writeIndex(widths.index, out);
  out.numbers(widths.bits.data(), widths.bits.size());
  out.vector(widths.weights);
  out.vector(widths.variances);
}

HilbertState::WidthBlock readWidths(ByteReader& in)
{
  HilbertState::WidthBlock widths;
  widths.index = readIndex<BlockIndex>(in);
  for (uint64_t& word : widths.bits) word = in.number<uint64_t>();
  widths.weights = in.vector<float>();
  widths.variances = in.vector<float>();
  return widths;
}

void writePoint(const HilbertState::Point& point, ByteWriter& out)
{
  writeMatrix(point.place, out);
  out.number(point.label);
  out.number(point.weight);
  out.number(!point.covariance.isZero(0));
  if (point.covariance.isZero(0)) return;
  writeMatrix(point.covariance, out);
  out.number(point.variance);
}

HilbertState::Point readPoint(ByteReader& in, uint8_t version)
{
  HilbertState::Point point;
  point.place = readMatrix<Eigen::Vector3d>(in);
  point.label = in.number<float>();
  point.weight = in.number<float>();
  if (!in.number<bool>()) return point;
  point.covariance = readMatrix<Eigen::Matrix3d>(in);
  if (version > 3) point.variance = in.number<double>();
  return point;
}
}  // namespace

void writeHilbertState(const HilbertState& state, ByteWriter& out)
{
  writeAll(state.blocks, out, [&](const HilbertState::Block& block) { writeBlock(block, out); });
  writeAll(state.seen, out, [&](const HilbertState::SeenBlock& seen) { writeSeen(seen, out); });
  writeAll(state.widths, out, [&](const HilbertState::WidthBlock& widths) { writeWidths(widths, out); });
  out.number(state.sgdSteps);
  writeAll(state.inducing, out, [&](const Eigen::Vector3d& place) { writeMatrix(place, out); });
  out.vector(state.classifier);
  writeAll(state.cells, out,
           [&](const HilbertState::CellPoints& points)
           {
             writeIndex(points.cell, out);
             out.number(points.hits);
             out.number(points.frees);
           });
  writeAll(state.points, out, [&](const HilbertState::Point& point) { writePoint(point, out); });
}

HilbertState readHilbertState(ByteReader& in, uint8_t version)
{
  HilbertState state;
  readAll(state.blocks, kIndexBytes + sizeof(SiteSet::Bits) + sizeof(uint64_t), in,
          [&] { return readBlock(in); });
  if (version > 1)
    readAll(state.seen, kIndexBytes + sizeof(SiteSet::Bits) + sizeof(uint64_t), in,
            [&] { return readSeen(in, version); });
  if (version > 2)
    readAll(state.widths, kIndexBytes + sizeof(SiteSet::Bits) + 2 * sizeof(uint64_t), in,
            [&] { return readWidths(in); });
  state.sgdSteps = in.number<uint64_t>();
  readAll(state.inducing, kPlaceBytes, in, [&] { return readMatrix<Eigen::Vector3d>(in); });
  state.classifier = in.vector<float>();
  readAll(state.cells, kIndexBytes + 2 * sizeof(float), in,
          [&]
          {
            HilbertState::CellPoints points;
            points.cell = readIndex<CellIndex>(in);
            points.hits = in.number<float>();
            points.frees = in.number<float>();
            return points;
          });
  readAll(state.points, kPlaceBytes + 2 * sizeof(float) + 1, in, [&] { return readPoint(in, version); });
  return state;
}

}  // namespace lamap
