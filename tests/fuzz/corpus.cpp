// Writes inputs to begin with:   fuzz_corpus FOLDER GOLDEN.lamap.gz...
// One folder for each target. Of the golden files those are taken that are small enough to be tried often.
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/cells/octomap_file.h>
#include <octomap/octomap.h>
#include <zlib.h>

#include <cstdio>
#include <filesystem>
#include <random>

#include "support/made_maps.h"

namespace
{
using namespace lamap;
namespace fs = std::filesystem;
using Bytes = std::vector<uint8_t>;

class Corpus
{
 public:
  explicit Corpus(fs::path folder) : folder_(std::move(folder)) {}

  void add(const std::string& target, const Bytes& bytes)
  {
    add(target, std::string(bytes.begin(), bytes.end()));
  }
  void add(const std::string& target, const std::string& bytes)
  {
    fs::create_directories(folder_ / target);
    std::ofstream(folder_ / target / ("begin-" + std::to_string(count_++)), std::ios::binary) << bytes;
  }

 private:
  fs::path folder_;
  size_t count_ = 0;
};

/// Of an object as MRPT stores it: its version and its content, without what the target puts before them.
Bytes versionAndContent(const Bytes& object)
{
  const size_t name = object.at(0) & 0x7FU;
  const size_t content = name + 2 + sizeof(uint64_t) + sizeof(uint32_t);
  Bytes bytes{object.at(name + 1)};
  bytes.insert(bytes.end(), object.begin() + static_cast<std::ptrdiff_t>(content), object.end() - 1);
  return bytes;
}

template <typename Map>
void addMaps(Corpus& corpus, const std::string& target, const std::vector<test::Settings>& variants)
{
  for (const test::Settings& settings : variants)
  {
    Map map = test::made<Map>(settings);
    map.setThreadCount(1);
    corpus.add(target, versionAndContent(test::bytesOf(map)));
    map.insertRay(0.6F, 0.1F, 0.1F, 0, 0, 0);
    corpus.add(target, versionAndContent(test::bytesOf(map)));
    map.insertRay(0.3F, -0.2F, 0.1F, 0, 0, 0);
    map.insertRay(0.4F, 0.5F, 0.2F, 0.1F, 0, 0);
    corpus.add(target, versionAndContent(test::bytesOf(map)));
  }
}

Bytes inflated(const std::string& path)
{
  gzFile file = gzopen(path.c_str(), "rb");
  Bytes bytes;
  uint8_t some[4096];
  for (int count = 0; file != nullptr && (count = gzread(file, some, sizeof(some))) > 0;)
    bytes.insert(bytes.end(), some, some + count);
  if (file != nullptr) gzclose(file);
  return bytes;
}

void addGolden(Corpus& corpus, const std::string& path)
{
  const Bytes object = inflated(path);
  constexpr size_t kLargest = size_t{8} << 10;
  if (object.size() < 64 || object.size() > kLargest) return;
  const std::string name(object.begin() + 1, object.begin() + 1 + (object[0] & 0x7F));
  for (const auto& [map, target] :
       std::map<std::string, std::string>{{"lamap::CBGKMap", "bgk_file"},
                                          {"lamap::CGPMap", "gp_file"},
                                          {"lamap::CHilbertMap", "hilbert_file"},
                                          {"lamap::COverlappingHilbertMap", "overlapping_file"}})
    if (name == map) corpus.add(target, versionAndContent(object));
}

void addMapFiles(Corpus& corpus)
{
  addMaps<CBGKMap>(corpus, "bgk_file",
                   {{},
                    {{"creationOpts.planar", "true"}, {"creationOpts.maxEvidence", "20"}},
                    {{"creationOpts.pruning", "none"}, {"insertOpts.beamWidth", "none"}},
                    {{"creationOpts.preset", "la3dm"}}});
  addMaps<CGPMap>(corpus, "gp_file",
                  {{}, {{"creationOpts.fusion", "bayes"}}, {{"creationOpts.preset", "thesis"}}});
  // Hilbert maps compute every cell that they are asked for: large ones, and narrow kernels, keep the maps
  // small.
  const std::pair<std::string, std::string> large("creationOpts.resolution", "0.5");
  const std::pair<std::string, std::string> narrow("creationOpts.gamma", "30");
  addMaps<CHilbertMap>(corpus, "hilbert_file",
                       {{large},
                        {large, {"insertOpts.trainingPoints", "points"}},
                        {large,
                         {"creationOpts.training", "batch"},
                         {"creationOpts.features", "nystroem"},
                         narrow,
                         {"creationOpts.components", "10"}},
                        {large, {"creationOpts.planar", "true"}}});
  addMaps<COverlappingHilbertMap>(
      corpus, "overlapping_file",
      {{large},
       {large, {"creationOpts.features", "nystroem"}, narrow, {"creationOpts.components", "8"}},
       {large, {"insertOpts.scansPerModel", "3"}},
       {large, {"creationOpts.keepModels", "false"}, {"creationOpts.planar", "true"}}});
}

/// Operations and observations are chosen by bytes: any will do.
void addNoise(Corpus& corpus)
{
  std::mt19937 random(1);
  for (const char* target : {"operations", "observation"})
    for (int i = 0; i < 40; ++i)
    {
      Bytes bytes(20 + random() % 200);
      for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random() % (i % 2 == 0 ? 256 : 200));
      corpus.add(target, bytes);
    }
}

void addClouds(Corpus& corpus)
{
  const auto header = [](const std::string& more, const std::string& data)
  {
    return "# .PCD v.7\nVERSION .7\nFIELDS x y z" + more +
           "\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 1 1 0 0 0\nPOINTS 2\nDATA " + data + "\n";
  };
  const std::string floats = "\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1";
  const std::string points("\0\0\x80\x3f\0\0\0\x40\0\0\x40\x40\0\0\x80\xbf\0\0\0\xc0\0\0\xc0\x7f", 24);
  corpus.add("pcd", header(floats, "ascii") + "1 2 3\n-1 -2 nan\n");
  corpus.add("pcd",
             header(" i\nSIZE 8 4 2 1\nTYPE F F I U\nCOUNT 1 1 1 3", "ascii") + "1 2 3 4 5 6\n1 2 3 4 5 6\n");
  corpus.add("pcd", header(floats, "binary") + points);
  corpus.add("pcd",
             header(floats, "binary_compressed") + std::string("\x1a\0\0\0\x18\0\0\0\x17", 9) + points);
}

void addTexts(Corpus& corpus)
{
  for (const char* poses :
       {"1 0.5 0 0 0 0 0 1\n2 1 0 0 0 0 0.7071068 0.7071068\n", "1 0 0 0 0.1 0 0\n# two\n2 1 0 0 0 0 0\n",
        "0 0 0 0\n1 1 0 0.5\n", "1 0 0 0.5 0 1 0 0 0 0 1 0\n"})
    corpus.add("poses", std::string(poses));
  for (const char* points :
       {"x,y,z\n0.05,0.05,0.15\n1,2,3\n", "1 2 3\n4;5;6\n", "prob,z,y,x\n0.5,1,2,3\n# end\n"})
    corpus.add("points", std::string(points));
  corpus.add("truth", std::string("x,y,z,label\n0.05,0.05,0.05,1\n0.15,0.05,0.05,0\n"));
  for (const char* pings : {"time,azimuth,range,bins\n1,0,3,0,50,0\n2,9,3,1,2,80\n",
                            "1 0 10 0 0 7 9 0\n1.5 -3 10 0 0 0 0 0\n", "1;2;4;5;6;7;\n"})
    corpus.add("pings", std::string(pings));
  for (const std::string map : {"bgkMap", "gpMap", "hilbertMap", "overlappingHilbertMap"})
    corpus.add("ini", test::iniOf(map, {{"creationOpts.resolution", "0.2"}, {"insertOpts.maxRange", "5"}}));
  corpus.add("ini", std::string("[App]\nbgkMap_count=1 // one\n[App_bgkMap_00_insertOpts]\nmaxRange=10\n"));
}

void addTrees(Corpus& corpus, const fs::path& scratch)
{
  CBGKMap map(0.1);
  map.setThreadCount(1);
  map.insertRay(0.5F, 0.1F, 0.1F, 0, 0, 0);
  const auto cells = tools::cellsOf(std::make_shared<CBGKMap>(map));
  for (const char* extension : {".ot", ".bt"})
  {
    const std::string path = (scratch / "tree").string() + extension;
    tools::writeOctomapFile(*cells, path);
    corpus.add("octree", std::string(1, extension[1] == 'o' ? '\0' : '\1') + test::contentOf(path));
    fs::remove(path);
  }
  octomap::ScanGraph graph;
  for (const float x : {1.0F, -1.0F})
  {
    auto points = std::make_unique<octomap::Pointcloud>();
    points->push_back(x, 2, 3);
    graph.addNode(points.release(), octomap::pose6d(0.1F, 0, 0, 0, 0, 0.2F));  // which owns them
  }
  const std::string path = (scratch / "scans.graph").string();
  graph.writeBinary(path);
  corpus.add("graph", test::contentOf(path));
  fs::remove(path);
}
}  // namespace

int main(int argc, char** argv)
{
  if (argc < 2)
  {
    std::fprintf(stderr, "usage: fuzz_corpus FOLDER GOLDEN.lamap.gz...\n");
    return 2;
  }
  const fs::path folder = argv[1];
  fs::create_directories(folder);
  Corpus corpus(folder);
  addMapFiles(corpus);
  for (int i = 2; i < argc; ++i) addGolden(corpus, argv[i]);
  addNoise(corpus);
  addClouds(corpus);
  addTexts(corpus);
  addTrees(corpus, folder);
}
