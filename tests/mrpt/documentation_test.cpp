// The tables of doc/options.md are those that the options' descriptions make. LAMAP_WRITE_DOC=1 in the
// environment writes them there.
#include <gtest/gtest.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>

#include <cstdlib>

#include "option_tables.h"

namespace
{
using namespace lamap::test;

/// Tables by where they stand: map, section ("presets" for those of its presets).
using Tables = std::map<std::pair<std::string, std::string>, std::string>;

template <typename Map>
void addTables(Tables& tables)
{
  const typename Map::TMapDefinition usual;
  const std::string alias = Map().alias();
  tables[{alias, "creationOpts"}] = tableOf(usual.creationOpts);
  tables[{alias, "insertOpts"}] = tableOf(usual.insertionOpts);
  tables[{alias, "presets"}] = presetTableOf<Map>();
}

Tables describedTables()
{
  Tables tables;
  addTables<lamap::CBGKMap>(tables);
  addTables<lamap::CGPMap>(tables);
  addTables<lamap::CHilbertMap>(tables);
  addTables<lamap::COverlappingHilbertMap>(tables);
  tables[{"", "likelihoodOpts"}] = tableOf(lamap::CLearnedMap::TLikelihoodOptions());
  tables[{"", "renderOpts"}] = tableOf(lamap::CLearnedMap::TRenderingOptions());
  return tables;
}

TEST(Documentation, TablesOfOptionsAreTheDescriptions)
{
  Tables tables = describedTables();
  const std::string page = readOptionsPage();
  std::istringstream in(page);
  std::string due;
  PagePlace place;
  bool inTable = false;
  for (std::string line; std::getline(in, line);)
  {
    place.see(line);
    const bool isPresets = line.rfind(kPresetsHeader, 0) == 0;
    if (isPresets || line == kDefaultsHeader)
    {
      const auto key = std::make_pair(place.map, isPresets ? std::string("presets") : place.section);
      EXPECT_EQ(tables.count(key), 1U) << "a second table of " << key.first << " " << key.second;
      due += tables[key];
      tables.erase(key);
      inTable = true;
    }
    else if (line.rfind("|", 0) != 0)
      inTable = false;
    if (!inTable) due += line + "\n";
  }
  for (const auto& [key, table] : tables)
    ADD_FAILURE() << "doc/options.md has no table of " << key.first << " " << key.second << ":\n" << table;
  if (std::getenv("LAMAP_WRITE_DOC")) std::ofstream(LAMAP_DOC_DIR "/options.md") << due;
  EXPECT_EQ(readOptionsPage(), due)
      << "LAMAP_WRITE_DOC=1 in the environment of this test brings the page up to date";
}
}  // namespace
