// What holds for the description of every struct of options.
#include <gtest/gtest.h>
#include <lamap_core/bgk/options.h>
#include <lamap_core/gp/options.h>
#include <lamap_core/hilbert/options.h>
#include <lamap_core/options/option_table.h>
#include <lamap_core/overlapping/options.h>

#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace lamap::test
{
namespace
{
/// Other content of an option than it has.
OptionContent another(const Option& option, const OptionContent& content)
{
  if (const auto* flag = std::get_if<bool>(&content)) return !*flag;
  if (const auto* choice = std::get_if<OptionChoice>(&content))
    return OptionChoice{(choice->number + 1) % option.names.size()};
  const double number = numberIn(content).value_or(0);
  if (option.type == OptionType::Unsigned) return static_cast<uint32_t>(number) + 1;
  if (option.type == OptionType::Signed) return static_cast<int32_t>(number) + 1;
  return number + 0.125;
}

/// By its own ==, if it has one.
template <typename Options>
auto areEqual(const Options& a, const Options& b, int /*preferred*/) -> decltype(a == b)
{
  return a == b;
}
template <typename Options>
bool areEqual(const Options& a, const Options& b, long /*else*/)
{
  return sameOptions(a, b);
}

template <typename Options>
class OptionTables : public ::testing::Test
{
};
using Structs = ::testing::Types<BgkStructure, BgkInference, GpStructure, GpInference, HilbertStructure,
                                 HilbertInference, OverlappingStructure, OverlappingInference>;
TYPED_TEST_SUITE(OptionTables, Structs);

TYPED_TEST(OptionTables, StructsDifferWhereAnyOptionDiffers)
{
  const TypeParam usual;
  EXPECT_TRUE(sameOptions(usual, usual));
  for (const Option& option : TypeParam::optionTable().options())
  {
    TypeParam changed;
    option.set(AnyOptions(&changed), another(option, option.get(ConstAnyOptions(&changed))));
    EXPECT_FALSE(sameOptions(changed, usual)) << option.key;
    EXPECT_FALSE(areEqual(changed, usual, 0)) << option.key;
    EXPECT_NE(option.textOf(ConstAnyOptions(&changed)), option.textOf(ConstAnyOptions(&usual))) << option.key;
    option.set(AnyOptions(&changed), option.get(ConstAnyOptions(&usual)));
    EXPECT_TRUE(sameOptions(changed, usual)) << option.key;
    EXPECT_TRUE(areEqual(changed, usual, 0)) << option.key;
  }
}

TYPED_TEST(OptionTables, DefaultsAreLegalAtTheirOwnResolution)
{
  const TypeParam usual;
  EXPECT_NO_THROW(requireLegalOptions(usual, 0.1));
  for (const Option& option : TypeParam::optionTable().options())
  {
    const std::string text = option.textOf(ConstAnyOptions(&usual));
    TypeParam read;
    if (!text.empty())
    {
      EXPECT_NO_THROW(option.parse(AnyOptions(&read), text)) << option.key;
    }
    EXPECT_TRUE(sameOptions(read, usual)) << option.key;
  }
}

TYPED_TEST(OptionTables, KeysAreUniqueAndEachOptionHasAMeaning)
{
  std::set<std::string> keys;
  for (const Option& option : TypeParam::optionTable().options())
  {
    EXPECT_TRUE(keys.insert(lowerCase(option.key)).second) << option.key << " stands twice";
    EXPECT_FALSE(option.doc.empty()) << option.key;
    EXPECT_EQ(option.doc.find('\n'), std::string::npos) << option.key;
    if (option.mayBeEmpty)
    {
      EXPECT_FALSE(option.emptyText.empty()) << option.key;
    }
    if (!option.floorKey.empty())
    {
      EXPECT_TRUE(TypeParam::optionTable().find(option.floorKey)) << option.key;
    }
  }
}

/// Conditions may name options of either struct of a map.
template <typename Structure, typename Inference>
void expectConditionsNameOptions()
{
  for (const OptionTable* table : {&Structure::optionTable(), &Inference::optionTable()})
    for (const Option& option : table->options())
      for (const Option::AnyOf& anyOf : option.conditions)
        for (const Option::Condition& condition : anyOf)
        {
          const Option* other = Structure::optionTable().find(condition.key);
          if (!other) other = Inference::optionTable().find(condition.key);
          ASSERT_TRUE(other) << option.key << " depends on " << condition.key;
          for (const std::string& text : condition.texts)
          {
            Structure structure;
            Inference inference;
            const bool isOfStructure = Structure::optionTable().find(condition.key) != nullptr;
            EXPECT_NO_THROW(
                other->parse(isOfStructure ? AnyOptions(&structure) : AnyOptions(&inference), text))
                << option.key << " depends on " << condition.key << " = " << text;
          }
        }
}

TEST(OptionConditions, NameOptionsAndTextsThatThereAre)
{
  expectConditionsNameOptions<BgkStructure, BgkInference>();
  expectConditionsNameOptions<GpStructure, GpInference>();
  expectConditionsNameOptions<HilbertStructure, HilbertInference>();
  expectConditionsNameOptions<OverlappingStructure, OverlappingInference>();
}

TEST(NumberText, IsShortAndReadsBack)
{
  EXPECT_EQ(shortText(1e6), "1e6");
  EXPECT_EQ(shortText(1e-5), "1e-5");
  EXPECT_EQ(shortText(0.1), "0.1");
  EXPECT_EQ(shortText(-1e13), "-1e13");
  EXPECT_EQ(roundedText(1.0 / 3), "0.333333");
  EXPECT_EQ(roundedText(1234567.0), "1.23457e+06");
  EXPECT_EQ(fixedText(2.0 / 3, 3), "0.667");
}

TEST(LegalRange, HoldsItsEndsInMetresAndInCells)
{
  const LegalRange range = metres().from(0).to(10).atLeastCells(0.5).atMostCells(4).orZero().range;
  EXPECT_TRUE(range.holds(0, 1.0));
  EXPECT_TRUE(range.holds(0.5, 1.0));
  EXPECT_FALSE(range.holds(0.25, 1.0));
  EXPECT_TRUE(range.holds(0.25));  // the resolution is not known
  EXPECT_TRUE(range.holds(4, 1.0));
  EXPECT_FALSE(range.holds(4.5, 1.0));
  EXPECT_FALSE(range.holds(11, 100.0));
  EXPECT_FALSE(range.holds(std::numeric_limits<double>::quiet_NaN(), 1.0));
}
}  // namespace
}  // namespace lamap::test
