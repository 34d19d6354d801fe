#pragma once

#include <gtest/gtest.h>
#include <lamap_mrpt/files/map_file.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <support/small_maps.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

namespace lamap::test
{
/// Where a map file that is kept among the tests stands.
inline std::string goldenFile(const std::string& name)
{
  return std::string(LAMAP_TEST_SOURCE_DIR) + "/golden/" + name + ".lamap.gz";
}

inline std::string bytesOfFile(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The map of a golden file. With LAMAP_WRITE_GOLDEN in the environment the file is written first.
/// @param learned today: what the file of the newest version holds
template <typename Map>
std::shared_ptr<Map> goldenMapOf(const std::string& name, const Map* learned)
{
  if (learned != nullptr && std::getenv("LAMAP_WRITE_GOLDEN")) saveMapFile(*learned, goldenFile(name));
  return std::dynamic_pointer_cast<Map>(loadMapFile(goldenFile(name)));
}

/// What a map file holds, however well it is compressed.
inline std::string contentOfFile(const std::string& path)
{
  mrpt::io::CFileGZInputStream file(path);
  std::string content;
  std::array<char, 4096> part{};
  while (const size_t count = file.Read(part.data(), part.size())) content.append(part.data(), count);
  return content;
}

/// Expects that a map saves to the content of a golden file.
template <typename Map>
void expectSavesAs(const Map& map, const std::string& name)
{
  const TemporaryFolder folder;
  saveMapFile(map, folder.file("again.lamap.gz"));
  const std::string golden = contentOfFile(goldenFile(name));
  EXPECT_GT(golden.size(), 100U);
  EXPECT_EQ(contentOfFile(folder.file("again.lamap.gz")), golden) << name;
}

/// Expects that a map of an older file, saved and loaded again, saves to the same bytes.
template <typename Map>
void expectSavesTheSameAgain(const Map& map)
{
  const TemporaryFolder folder;
  saveMapFile(map, folder.file("once.lamap.gz"));
  saveMapFile(*loadMapFile(folder.file("once.lamap.gz")), folder.file("twice.lamap.gz"));
  EXPECT_EQ(bytesOfFile(folder.file("once.lamap.gz")), bytesOfFile(folder.file("twice.lamap.gz")));
}

}  // namespace lamap::test
