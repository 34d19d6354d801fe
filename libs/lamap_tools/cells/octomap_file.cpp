#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/cells/octomap_file.h>
#include <lamap_tools/files/file_input.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/report/counted.h>
#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
/// OctoMap's key of the cell with index 0.
constexpr int kKeyOfZero = 32768;

template <class Tree>
class OctomapCells : public CellMap
{
 public:
  explicit OctomapCells(std::unique_ptr<Tree> tree) : tree_(std::move(tree)) {}

  std::string className() const override { return "octomap::" + tree_->getTreeType(); }
  double resolution() const override { return tree_->getResolution(); }
  std::vector<std::string> evidenceNames() const override { return {"logodds"}; }

  std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override
  {
    // OctoMap casts what is too far away for its keys.
    const auto cell = cellAt({point_map.x, point_map.y, point_map.z}, resolution());
    const auto isKey = [](int32_t index) { return index >= -kKeyOfZero && index < kKeyOfZero; };
    if (!cell || !isKey(cell->x) || !isKey(cell->y) || !isKey(cell->z)) return std::nullopt;
    octomap::OcTreeKey key;
    if (!tree_->coordToKeyChecked(point_map.x, point_map.y, point_map.z, key)) return std::nullopt;
    const auto* node = tree_->search(key);
    if (node == nullptr) return std::nullopt;
    return estimateOf(*node);
  }

  void visitCells(const CellVisitor& visitor) const override { visitCellsOfLeaves(*this, visitor); }

  void visitLeaves(const LeafVisitor& visitor) const override
  {
    for (auto leaf = tree_->begin_leafs(), end = tree_->end_leafs(); leaf != end; ++leaf)
    {
      const int edge = 1 << (tree_->getTreeDepth() - leaf.getDepth());
      const CellEstimate estimate = estimateOf(*leaf);
      const octomap::OcTreeKey first = leaf.getIndexKey();
      visitor({first[0] - kKeyOfZero, first[1] - kKeyOfZero, first[2] - kKeyOfZero}, edge, estimate);
    }
  }

 private:
  template <class Node>
  CellEstimate estimateOf(const Node& node) const
  {
    CellEstimate estimate;
    const double logodds = static_cast<double>(node.getLogOdds());
    estimate.prob = 1.0 / (1.0 + std::exp(-logodds));
    estimate.state = tree_->isNodeOccupied(node) ? CellState::Occupied : CellState::Free;
    estimate.evidence[0] = logodds;
    return estimate;
  }

  std::unique_ptr<Tree> tree_;
};

/// What the text header of both formats says, lines of "key value" up to "data".
struct OctomapHeader
{
  std::string id;
  std::optional<size_t> nodes;  ///< nothing: not stated
  double resolution_m = 0;
};

std::optional<OctomapHeader> readHeader(std::istream& in, const std::string& magic)
{
  OctomapHeader header;
  std::string line;
  if (!std::getline(in, line) || line.compare(0, magic.size(), magic) != 0) return std::nullopt;
  constexpr int kMaxHeaderLines = 1000;
  for (int count = 0; count < kMaxHeaderLines && std::getline(in, line); ++count)
  {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "data") return header;
    if (key == "id") words >> header.id;
    if (key == "size")
      if (size_t nodes = 0; words >> nodes) header.nodes = nodes;
    if (key == "res") words >> header.resolution_m;
  }
  return std::nullopt;
}

[[noreturn]] void failRead(const std::string& path, const std::string& why)
{
  throw std::runtime_error(path + ": " + why);
}

constexpr int kTreeDepth = 16;

/** Walks the nodes of a file without building them. OctoMap itself goes on making children when the bytes
 * have run out or lie, so a file is let in only after this.
 * @return nodes at and below this one; nothing if the file ends too early or the tree is deeper than
 * OctoMap's. */
std::optional<size_t> countNodes(std::istream& in, size_t bytesBeforeChildren, int depth)
{
  std::array<char, 16> skipped{};
  char children = 0;
  in.read(skipped.data(), static_cast<std::streamsize>(bytesBeforeChildren));
  if (!in.get(children) || (depth == kTreeDepth && children != 0)) return std::nullopt;
  size_t nodes = 1;
  for (int child = 0; child < 8; ++child)
  {
    if ((static_cast<unsigned char>(children) >> child & 1U) == 0) continue;
    const auto below = countNodes(in, bytesBeforeChildren, depth + 1);
    if (!below) return std::nullopt;
    nodes += *below;
  }
  return nodes;
}

/// The same for .bt: an inner node is two bits for each child; 0 none, 1 and 2 leaves, 3 an inner node that
/// follows.
std::optional<size_t> countBinaryNodes(std::istream& in, int depth)
{
  std::array<char, 2> bytes{};
  if (!in.read(bytes.data(), 2)) return std::nullopt;
  const unsigned labels =
      static_cast<unsigned char>(bytes[0]) | unsigned{static_cast<unsigned char>(bytes[1])} << 8U;
  size_t nodes = 1;
  for (int child = 0; child < 8; ++child)
  {
    const unsigned label = labels >> (2 * child) & 3U;
    if (label != 0 && depth == kTreeDepth) return std::nullopt;
    if (label == 1 || label == 2) ++nodes;
    if (label != 3) continue;
    const auto below = countBinaryNodes(in, depth + 1);
    if (!below) return std::nullopt;
    nodes += *below;
  }
  return nodes;
}

/// @return whether there is a tree. @throws std::runtime_error if it is not whole
bool holdsTree(const std::string& path, const OctomapHeader& header, std::istream& in, bool binary)
{
  if (header.nodes == 0U || (!header.nodes && in.peek() == std::istream::traits_type::eof())) return false;
  const auto begin = in.tellg();
  const size_t bytesBeforeChildren = header.id == "ColorOcTree" ? sizeof(float) + 3 : sizeof(float);
  const auto nodes = binary ? countBinaryNodes(in, 0) : countNodes(in, bytesBeforeChildren, 0);
  if (!nodes || (header.nodes && nodes != header.nodes))
    failRead(path, "is cut short or damaged: its header says " +
                       (header.nodes ? counted(*header.nodes, "node") : "no size") + ", " +
                       (nodes ? "it holds " + std::to_string(*nodes) : "its tree does not end well"));
  in.clear();
  in.seekg(begin);
  return true;
}

/// @throws std::runtime_error if a node's log-odds are not finite: OctoMap would call NaN free.
template <class Tree>
void requireFinite(const std::string& path, const Tree& tree)
{
  for (auto node = tree.begin_tree(), end = tree.end_tree(); node != end; ++node)
    if (!std::isfinite(node->getLogOdds()))
      failRead(path, "has a node at (" + std::to_string(node.getX()) + ", " + std::to_string(node.getY()) +
                         ", " + std::to_string(node.getZ()) + ") whose log-odds are " +
                         std::to_string(node->getLogOdds()) + "; they must be finite");
}

template <class Tree>
std::unique_ptr<CellMap> readTree(const std::string& path, const OctomapHeader& header, std::istream& in,
                                  bool binary)
{
  auto tree = std::make_unique<Tree>(header.resolution_m);
  if (holdsTree(path, header, in, binary)) binary ? tree->readBinaryData(in) : tree->readData(in);
  requireFinite(path, *tree);
  return std::make_unique<OctomapCells<Tree>>(std::move(tree));
}

const char* firstLine(bool binary)
{
  return binary ? "# Octomap OcTree binary file" : "# Octomap OcTree file";
}
}  // namespace

bool isOctomapFile(const std::string& path)
{
  const std::string extension = extensionOf(path);
  return extension == ".ot" || extension == ".bt";
}

std::unique_ptr<CellMap> readOctomapFile(const std::string& path)
{
  std::ifstream in = openedFile(path, "a file", std::ios::binary);
  const bool binary = extensionOf(path) == ".bt";
  const auto header = readHeader(in, firstLine(binary));
  if (!header)
    failRead(path, std::string("is not an OctoMap ") + (binary ? ".bt" : ".ot") + " file (no '" +
                       firstLine(binary) + "' header)");
  requireReadableResolution(path, header->resolution_m);
  if (binary || header->id == "OcTree") return readTree<octomap::OcTree>(path, *header, in, binary);
  if (header->id == "ColorOcTree") return readTree<octomap::ColorOcTree>(path, *header, in, binary);
  failRead(path, "holds a tree of kind '" + header->id + "'; expected OcTree or ColorOcTree");
}

void requireOctomapKeys(const CellExtent& extent, const std::string& path, double resolution_m)
{
  const auto beyond = [](int index) { return index < -kKeyOfZero || index >= kKeyOfZero; };
  const CellIndex& a = extent.first;
  const CellIndex& b = extent.last;
  if (!beyond(a.x) && !beyond(a.y) && !beyond(a.z) && !beyond(b.x) && !beyond(b.y) && !beyond(b.z)) return;
  std::ostringstream why;
  why.precision(10);
  why << path << ": OctoMap's files reach 32,768 cells from the origin (" << kKeyOfZero * resolution_m
      << " m at " << resolution_m << " m), the map extends over x " << a.x * resolution_m << " .. "
      << (b.x + 1.0) * resolution_m << " m, y " << a.y * resolution_m << " .. " << (b.y + 1.0) * resolution_m
      << " m, z " << a.z * resolution_m << " .. " << (b.z + 1.0) * resolution_m << " m";
  throw std::runtime_error(why.str());
}

namespace
{
/// OctoMap's own writers cut the resolution to six digits and talk on the standard error.
void writeTree(const octomap::OcTree& tree, bool binary, std::ostream& out)
{
  out << firstLine(binary)
      << "\n# (feel free to add / change comments, but leave the first line as it is!)\n#\nid "
      << tree.getTreeType() << "\nsize " << tree.size() << "\nres " << shortest(tree.getResolution())
      << "\ndata\n";
  if (binary)
    tree.writeBinaryData(out);
  else
    tree.writeData(out);
}

octomap::OcTreeKey keyOf(const CellIndex& cell)
{
  const auto key = [](int index) { return static_cast<octomap::key_type>(index + kKeyOfZero); };
  return {key(cell.x), key(cell.y), key(cell.z)};
}
}  // namespace

void writeOctomap(const CellMap& map, const std::string& path, std::ostream& out)
{
  const bool binary = extensionOf(path) == ".bt";
  const auto extent = cellExtent(map);
  if (!extent) throw std::runtime_error(path + ": the map is empty, there is no cell to write");
  requireOctomapKeys(*extent, path, map.resolution());

  octomap::OcTree tree(map.resolution());
  tree.setClampingThresMin(0);  // log-odds -inf .. inf: setNodeValue clamps to these
  tree.setClampingThresMax(1);
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (binary && estimate.state == CellState::Unknown) return;
        const double logodds = binary ? (estimate.state == CellState::Occupied ? 1.0 : -1.0)
                                      : std::log(estimate.prob) - std::log1p(-estimate.prob);
        constexpr bool kUpdateInnerNodesLater = true;
        tree.setNodeValue(keyOf(cell), static_cast<float>(logodds), kUpdateInnerNodesLater);
      });
  if (tree.size() == 0)
    throw std::runtime_error(path +
                             ": no cell is free or occupied, a .bt file has nothing to hold; .ot keeps "
                             "probabilities of unknown cells too");
  tree.updateInnerOccupancy();
  tree.prune();
  writeTree(tree, binary, out);
}

void writeOctomapFile(const CellMap& map, const std::string& path)
{
  AtomicFile file(path);
  std::ofstream out(file.temporaryPath(), std::ios::binary | std::ios::trunc);
  writeOctomap(map, path, out);
  out.close();
  if (!out) throw std::runtime_error(path + ": cannot be written: " + std::strerror(errno));
  file.commit();
}

}  // namespace lamap::tools
