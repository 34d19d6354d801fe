// What doc/options.md says is legal is what is accepted, for every option of every map: from an .ini file, by
// the options' validate(), and from a map file.
#include <gtest/gtest.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>

#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include <support/made_maps.h>
#include "option_tables.h"

namespace
{
using lamap::ConstAnyOptions;
using lamap::Option;
using lamap::OptionContent;
using lamap::OptionType;
using lamap::TOptionGroup;
using namespace lamap::test;

constexpr double kResolution_m = 0.1;

/// The ends of what is legal, read from the words of the page.
struct DocumentedRange
{
  double low = -std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::max();
  bool lowIncluded = true;
  bool orZero = false;
  std::string floorKey;
  bool floorIncluded = true;

  explicit DocumentedRange(std::string text)
  {
    const std::string zero = "0, or ";
    if (text.rfind(zero, 0) == 0) orZero = true, text = text.substr(zero.size());
    for (size_t begin = 0; begin < text.size();)
    {
      const size_t end = std::min(text.find(", ", begin), text.size());
      read(text.substr(begin, end - begin));
      begin = end + 2;
    }
  }

 private:
  void read(const std::string& part)
  {
    std::istringstream words(part);
    std::string first, second, third;
    words >> first >> second >> third;
    const bool inCells = part.find(" cell") != std::string::npos;
    const auto number = [&](const std::string& word)
    {
      const size_t slash = word.find('/');
      const double parsed =
          slash == std::string::npos ? std::stod(word) : std::stod(word) / std::stod(word.substr(slash + 1));
      return inCells ? parsed * kResolution_m : parsed;
    };
    if (second.rfind("`", 0) == 0)  // > `minRange`, >= `freeThreshold`
    {
      floorKey = second.substr(1, second.size() - 2);
      floorIncluded = first == ">=";
    }
    else if (second == "to")
      low = std::max(low, number(first)), high = std::min(high, number(third));
    else if (first == ">")
      low = number(second), lowIncluded = false;
    else if (first == "at" && second == "least")
      low = std::max(low, number(third)), lowIncluded = true;
    else if (first == "at" && second == "most")
      high = std::min(high, number(third));
    else if (first == "from")  // 1/1000 cell to 64 cells
    {
      std::string to, most;
      words >> to >> most;
      low = std::max(low, number(second)), lowIncluded = true;
      high = std::min(high, number(most));
    }
    else if (first == "within")
      low = std::max(low, -number(second)), high = std::min(high, number(second));
    else
      throw std::logic_error("not understood: " + part);
  }
};

/// Settings beside which an end of a range makes sense: thresholds in order, and kernels that suit the
/// lattice and the cells.
Settings companionsOf(const std::string& map, const std::string& key, bool atHighEnd)
{
  if (key == "freeThreshold") return {{"insertOpts.occupiedThreshold", "1"}};
  if (key == "occupiedThreshold") return {{"insertOpts.freeThreshold", "0"}};
  if (map == "gpMap" && key == "resolution" && atHighEnd) return {{"insertOpts.lengthScale", "1000"}};
  if (map != "hilbertMap" && map != "overlappingHilbertMap") return {};
  const std::pair<std::string, std::string> narrow{"creationOpts.gamma", "1e6"};
  if (key == "gamma" && atHighEnd) return {{"creationOpts.latticeSpacing", "0.001"}};
  if (key == "gamma") return {{"creationOpts.latticeSpacing", "1000"}, {"creationOpts.resolution", "100"}};
  if (key == "cutoff" && atHighEnd) return {{"creationOpts.latticeSpacing", "0.005"}};
  if (key == "latticeSpacing" && atHighEnd)
    return {
        {"creationOpts.gamma", "1e-6"}, {"creationOpts.cutoff", "1e-6"}, {"creationOpts.resolution", "100"}};
  if (key == "latticeSpacing") return {narrow, {"creationOpts.cutoff", "0.96"}};
  if (key == "resolution" && !atHighEnd) return {narrow, {"creationOpts.latticeSpacing", "0.001"}};
  return {};
}

/// What a number is as content of an option; nothing if its type cannot hold it.
std::optional<OptionContent> contentOf(const Option& option, double number)
{
  if (option.type == OptionType::Number) return number;
  if (option.type == OptionType::Signed) return static_cast<int32_t>(number);
  if (number < 0 || number > std::numeric_limits<uint32_t>::max()) return std::nullopt;
  return static_cast<uint32_t>(number);
}

/// A definition, with ways to ask whether an option may be a number.
template <typename Map>
struct Asked
{
  typename Map::TMapDefinition definition;
  Settings companions;

  TOptionGroup& group(const std::string& section)
  {
    if (section == "creationOpts") return definition.creationOpts;
    if (section == "insertOpts") return definition.insertionOpts;
    if (section == "likelihoodOpts") return definition.likelihoodOpts;
    return definition.renderingOpts;
  }

  explicit Asked(const Settings& settings) : companions(settings)
  {
    for (const auto& [name, text] : companions)
    {
      TOptionGroup& of = group(name.substr(0, name.find('.')));
      of.optionTable().require(name.substr(name.find('.') + 1)).parse(of, text);
    }
  }

  template <typename Try>
  static bool succeeds(Try&& attempt)
  {
    try
    {
      attempt();
      return true;
    }
    catch (const std::exception&)
    {
      return false;
    }
  }

  bool byIni(const std::string& section, const Option& option, double number)
  {
    Settings settings = companions;
    const bool isWhole = option.type != OptionType::Number;
    settings.emplace_back(section + "." + option.key,
                          isWhole ? std::to_string(static_cast<int64_t>(number)) : lamap::shortText(number));
    return succeeds(
        [&]
        {
          typename Map::TMapDefinition loaded;
          loaded.loadFromConfigFile(mrpt::config::CConfigFileMemory(iniOf("x", settings)), "map_x_00");
        });
  }

  bool byValidate()
  {
    return succeeds(
        [&]
        {
          for (const char* section : {"creationOpts", "likelihoodOpts", "renderOpts"})
            group(section).validate();
          (void)definition.resolvedInsertion();
        });
  }

  bool byFile(const std::string& section)
  {
    return succeeds(
        [&]
        {
          if (section == "creationOpts")
          {
            lamap::ByteWriter bytes;
            definition.creationOpts.write(bytes);
            lamap::ByteReader reader(bytes.bytes());
            typename Map::TCreationOptions read;
            read.read(reader);
            return read.validate();
          }
          Map map(definition.creationOpts);
          map.insertionOptions = definition.insertionOpts;
          map.likelihoodOptions = definition.likelihoodOpts;
          map.renderingOptions = definition.renderingOpts;
          (void)objectFrom(bytesOf(map));
        });
  }

  void expect(bool legal, const std::string& section, const Option& option, double number)
  {
    SCOPED_TRACE(section + "." + option.key + " = " + lamap::shortText(number) +
                 (legal ? "" : ", not legal"));
    EXPECT_EQ(byIni(section, option, number), legal) << "from an .ini file";
    const auto content = contentOf(option, number);
    if (!content) return;
    option.set(group(section), *content);
    EXPECT_EQ(byValidate(), legal) << "by validate()";
    EXPECT_EQ(byFile(section), legal) << "from a file";
  }
};

/// The next number that an option can hold.
double beyond(const Option& option, double end, double towards)
{
  if (option.type == OptionType::Number) return std::nextafter(end, towards);
  return end + (towards > end ? 1 : -1);
}

template <typename Map>
void expectEnds(const std::string& section, const Option& option, const DocumentedRange& range)
{
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::string alias = Map().alias();
  const auto ask = [&](bool legal, double number, bool atHighEnd)
  { Asked<Map>(companionsOf(alias, option.key, atHighEnd)).expect(legal, section, option, number); };
  ask(true, range.high, true);
  ask(false, beyond(option, range.high, kInfinity), true);
  if (range.orZero) ask(true, 0, false);
  if (range.floorKey.empty())
  {
    ask(range.lowIncluded, range.low, false);
    if (!range.lowIncluded) ask(true, range.low + 1e-6, false);
    ask(false, beyond(option, range.low, -kInfinity), false);
    return;
  }
  const double floor = 0.5;
  const auto askBesideFloor = [&](bool legal, double number) {
    Asked<Map>({{section + "." + range.floorKey, "0.5"}}).expect(legal, section, option, number);
  };
  askBesideFloor(range.floorIncluded, floor);
  askBesideFloor(true, std::nextafter(floor, 1));
  askBesideFloor(false, std::nextafter(floor, 0));
}

template <typename Map>
class OptionRanges : public ::testing::Test
{
};
using Maps =
    ::testing::Types<lamap::CBGKMap, lamap::CHilbertMap, lamap::COverlappingHilbertMap, lamap::CGPMap>;
TYPED_TEST_SUITE(OptionRanges, Maps);

TYPED_TEST(OptionRanges, AreAcceptedToTheirDocumentedEndsAndRefusedBeyond)
{
  const TypeParam map;
  const auto documented = documentedOptions();
  size_t numbers = 0;
  map.visitOptionGroups(
      [&](const TOptionGroup& group, TOptionGroup&)
      {
        const lamap::OptionTable& table = group.optionTable();
        const bool isOwn = table.name() == "creationOpts" || table.name() == "insertOpts";
        const auto& rows = documented.at({isOwn ? map.alias() : "", table.name()});
        ASSERT_EQ(rows.size(), table.options().size());
        for (size_t i = 0; i < rows.size(); ++i)
        {
          const Option& option = table.options()[i];
          ASSERT_EQ(rows[i].key, option.key);
          if (option.type == OptionType::Number || option.type == OptionType::Unsigned ||
              option.type == OptionType::Signed)
          {
            expectEnds<TypeParam>(table.name(), option, DocumentedRange(rows[i].legal));
            ++numbers;
          }
        }
      });
  EXPECT_GT(numbers, 20U);
}

TYPED_TEST(OptionRanges, NamesOfChoicesAreAllDocumentedAndAccepted)
{
  const TypeParam map;
  const auto documented = documentedOptions();
  map.visitOptionGroups(
      [&](const TOptionGroup& group, TOptionGroup& untouched)
      {
        const lamap::OptionTable& table = group.optionTable();
        const bool isOwn = table.name() == "creationOpts" || table.name() == "insertOpts";
        for (const DocumentedOption& row : documented.at({isOwn ? map.alias() : "", table.name()}))
        {
          const Option& option = table.require(row.key);
          if (option.type != OptionType::Choice) continue;
          std::set<std::string> names;
          for (size_t begin = 0; (begin = row.legal.find('`', begin)) != std::string::npos;)
          {
            const size_t end = row.legal.find('`', begin + 1);
            names.insert(row.legal.substr(begin + 1, end - begin - 1));
            begin = end + 1;
          }
          EXPECT_EQ(names, std::set<std::string>(option.names.begin(), option.names.end())) << row.key;
          for (const std::string& name : names)
          {
            option.parse(untouched, name);
            EXPECT_EQ(option.textOf(untouched), name);
          }
          EXPECT_THROW(option.parse(untouched, row.key), std::invalid_argument);
        }
      });
}

// Whatever number a caller casts into an enumeration.
TYPED_TEST(OptionRanges, WhatIsNoEnumeratorIsRefusedByName)
{
  const TypeParam map;
  size_t choices = 0;
  map.visitOptionGroups(
      [&](const TOptionGroup& group, TOptionGroup&)
      {
        for (const Option& option : group.optionTable().options())
        {
          if (option.type != OptionType::Choice) continue;
          ++choices;
          for (const size_t number : {option.names.size(), std::numeric_limits<size_t>::max()})
          {
            SCOPED_TRACE(group.optionTable().name() + "." + option.key);
            Asked<TypeParam> asked({});
            TOptionGroup& changed = asked.group(group.optionTable().name());
            option.set(changed, lamap::OptionChoice{number});
            EXPECT_FALSE(asked.byValidate());
            EXPECT_FALSE(asked.byFile(group.optionTable().name()));
            try
            {
              changed.validate();
              ADD_FAILURE() << "number " << number << " is taken";
            }
            catch (const std::invalid_argument& error)
            {
              EXPECT_EQ(error.what(), option.key + " is not an enumerator: must be " + option.legalText());
            }
            EXPECT_EQ(option.textOf(changed), "?");
          }
        }
      });
  EXPECT_GE(choices, 4U);
}

/// Another thing than the map's default is refused with the name, the value and what is legal.
TEST(OptionRanges, ARefusalNamesTheOptionItsValueAndTheRange)
{
  lamap::BgkInference inference;
  inference.kernelSupport = 6.5;
  try
  {
    inference.validate(0.1);
    FAIL() << "a support of 65 cells is taken";
  }
  catch (const std::invalid_argument& error)
  {
    EXPECT_STREQ(
        error.what(),
        "kernelSupport = 6.5: must be a number > 0, at most 1e6, from 1/1000 cell to 64 cells, in m");
  }
}
}  // namespace
