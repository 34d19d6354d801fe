#include <lamap_mrpt/options/option_table.h>

#include <lamap_mrpt/files/payload.h>
#include <lamap_mrpt/options/nearest_name.h>
#include <mrpt/config/CConfigFile.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <stdexcept>

namespace lamap
{
namespace
{
std::string lower(std::string text)
{
  for (char& letter : text)
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  return text;
}

/// Shortest text that reads back as the same number.
std::string shortest(double number)
{
  char text[32];
  const auto end = std::to_chars(text, text + sizeof(text), number);
  return {text, end.ptr};
}

/// Whole text to number, the decimal point is a point everywhere; nothing if it is no number.
template <typename T>
std::optional<T> toNumber(std::string_view text)
{
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<bool> toFlag(const std::string& text)
{
  const std::string word = lower(text);
  if (word == "true" || word == "yes" || word == "on" || word == "1") return true;
  if (word == "false" || word == "no" || word == "off" || word == "0") return false;
  return std::nullopt;
}

constexpr const char* kLegalFlag = "true or false";

template <typename... Cases>
struct Overloaded : Cases...
{
  using Cases::operator()...;
};
template <typename... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

/// Members are reached through functions of a changeable group; reading through them changes nothing.
template <typename T>
const T& read(const Option::Member<T>& member, const TOptionGroup& group)
{
  return member(const_cast<TOptionGroup&>(group));
}

/// Number of each type of content in files; never to be changed.
enum class StoredType : uint8_t
{
  Number = 1,
  Empty = 2,
  Unsigned = 3,
  Signed = 4,
  Flag = 5,
  Text = 6,
  Choice = 7
};

std::string quoted(const std::string& text)
{
  return '"' + text + '"';
}

/// A stored text for a message: a damaged file may hold any bytes, and any number of them.
std::string printable(const std::string& text)
{
  constexpr size_t kMost = 60;
  std::string shown = text.substr(0, kMost);
  for (char& letter : shown)
    if (letter < ' ' || letter > '~') letter = '?';
  return text.size() > kMost ? shown + "..." : shown;
}

/// What stands before "is not …": insertOpts.maxRange = "30m" in section [x] of file.ini.
std::string place(const std::string& table, const std::string& key, const std::string& text,
                  const std::string& section, const mrpt::config::CConfigFileBase& source)
{
  return table + "." + key + " = " + quoted(text) + " in section " + quoted(section) + " of " +
         nameOf(source);
}

/// What a section lists, and options of the table that it has without listing them: see hasKey().
std::vector<std::string> keysOf(const mrpt::config::CConfigFileBase& source, const std::string& section,
                                const OptionTable& table)
{
  std::vector<std::string> keys;
  source.getAllKeys(section, keys);
  const std::vector<std::string> listed = keys;
  for (const Option& option : table.options())
  {
    const auto isIt = [&](const std::string& key) { return lower(key) == lower(option.key); };
    if (std::none_of(listed.begin(), listed.end(), isIt) && hasKey(source, section, option.key))
      keys.push_back(option.key);
  }
  return keys;
}
}  // namespace

std::string LegalRange::asText(const std::string& noun) const
{
  const LegalRange any;
  const bool below = low > any.low;
  const bool above = high < any.high;
  if (below && above && lowIncluded) return noun + " from " + shortest(low) + " to " + shortest(high);
  if (below && above) return noun + " > " + shortest(low) + ", at most " + shortest(high);
  if (below) return noun + (lowIncluded ? " >= " : " > ") + shortest(low);
  if (above) return noun + " <= " + shortest(high);
  return noun;
}

std::string Option::textOf(const TOptionGroup& group) const
{
  return std::visit(
      Overloaded{[&](const Member<double>& member) { return shortest(lamap::read(member, group)); },
                 [&](const Member<std::optional<double>>& member)
                 {
                   const std::optional<double>& length = lamap::read(member, group);
                   return length ? shortest(*length) : std::string();
                 },
                 [&](const Member<uint32_t>& member) { return std::to_string(lamap::read(member, group)); },
                 [&](const Member<std::optional<uint32_t>>& member)
                 {
                   const std::optional<uint32_t>& number = lamap::read(member, group);
                   return number ? std::to_string(*number) : std::string();
                 },
                 [&](const Member<int>& member) { return std::to_string(lamap::read(member, group)); },
                 [&](const Member<bool>& member)
                 { return std::string(lamap::read(member, group) ? "true" : "false"); },
                 [&](const Member<std::string>& member) { return lamap::read(member, group); },
                 [&](const Choice& choice)
                 { return choice.names.at(static_cast<size_t>(choice.get(group))); }},
      access);
}

std::string Option::legalText() const
{
  const std::string inUnit = unit.empty() ? "" : ", in " + unit + " (without the unit)";
  return std::visit(
      Overloaded{[&](const Member<double>&) { return range.asText("a number") + inUnit; },
                 [&](const Member<std::optional<double>>&) { return range.asText("a number") + inUnit; },
                 [&](const Member<uint32_t>&) { return range.asText("a whole number") + inUnit; },
                 [&](const Member<std::optional<uint32_t>>&)
                 { return range.asText("a whole number") + inUnit; },
                 [&](const Member<int>&) { return range.asText("a whole number") + inUnit; },
                 [&](const Member<bool>&) { return std::string(kLegalFlag); },
                 [&](const Member<std::string>&) { return std::string("a text"); },
                 [&](const Choice& choice)
                 {
                   std::string all = "one of:";
                   for (const std::string& name : choice.names)
                     all += (all.back() == ':' ? " " : ", ") + name;
                   return all;
                 }},
      access);
}

void Option::parse(TOptionGroup& group, const std::string& text) const
{
  const auto refuse = [&](const std::string& what)
  { throw std::invalid_argument(what + "; legal is " + legalText()); };
  const auto legal = [&](auto number, const char* noun)
  {
    if (!number) refuse(std::string("is not ") + noun);
    if (!range.holds(static_cast<double>(*number))) refuse("is out of range");
    return *number;
  };
  const auto finite = [&]
  {
    const auto number = toNumber<double>(text);
    if (number && !std::isfinite(*number)) refuse("is not a finite number");
    return legal(number, "a number");
  };
  std::visit(Overloaded{[&](const Member<double>& member) { member(group) = finite(); },
                        [&](const Member<std::optional<double>>& member) { member(group) = finite(); },
                        [&](const Member<uint32_t>& member)
                        { member(group) = legal(toNumber<uint32_t>(text), "a whole number >= 0"); },
                        [&](const Member<std::optional<uint32_t>>& member)
                        { member(group) = legal(toNumber<uint32_t>(text), "a whole number >= 0"); },
                        [&](const Member<int>& member)
                        { member(group) = legal(toNumber<int>(text), "a whole number"); },
                        [&](const Member<bool>& member)
                        {
                          const auto flag = toFlag(text);
                          if (!flag) refuse("is neither yes nor no");
                          member(group) = *flag;
                        },
                        [&](const Member<std::string>& member) { member(group) = text; },
                        [&](const Choice& choice)
                        {
                          for (size_t i = 0; i < choice.names.size(); ++i)
                            if (lower(choice.names[i]) == lower(text))
                              return choice.set(group, static_cast<int>(i));
                          refuse("is not known (nearest: " + nearestOf(text, choice.names) + ")");
                        }},
             access);
}

void Option::write(const TOptionGroup& group, ByteWriter& out) const
{
  const auto put = [&](StoredType type, auto content)
  {
    out.number(static_cast<uint8_t>(type));
    out.number(content);
  };
  std::visit(
      Overloaded{[&](const Member<double>& member) { put(StoredType::Number, lamap::read(member, group)); },
                 [&](const Member<std::optional<double>>& member)
                 {
                   const std::optional<double>& length = lamap::read(member, group);
                   if (length)
                     put(StoredType::Number, *length);
                   else
                     out.number(static_cast<uint8_t>(StoredType::Empty));
                 },
                 [&](const Member<uint32_t>& member)
                 { put(StoredType::Unsigned, lamap::read(member, group)); },
                 [&](const Member<std::optional<uint32_t>>& member)
                 {
                   const std::optional<uint32_t>& number = lamap::read(member, group);
                   if (number)
                     put(StoredType::Unsigned, *number);
                   else
                     out.number(static_cast<uint8_t>(StoredType::Empty));
                 },
                 [&](const Member<int>& member)
                 { put(StoredType::Signed, static_cast<int32_t>(lamap::read(member, group))); },
                 [&](const Member<bool>& member) { put(StoredType::Flag, lamap::read(member, group)); },
                 [&](const Member<std::string>& member)
                 {
                   out.number(static_cast<uint8_t>(StoredType::Text));
                   out.text(lamap::read(member, group));
                 },
                 // By name: enumerators may be reordered.
                 [&](const Choice& choice)
                 {
                   out.number(static_cast<uint8_t>(StoredType::Choice));
                   out.text(choice.names.at(static_cast<size_t>(choice.get(group))));
                 }},
      access);
}

void Option::read(TOptionGroup& group, ByteReader& in) const
{
  const auto type = static_cast<StoredType>(in.number<uint8_t>());
  const auto expect = [&](StoredType due)
  {
    if (type != due) in.fail("option " + key + " is stored with another type");
  };
  const auto legal = [&](auto number)
  {
    if (!range.holds(static_cast<double>(number)))
      in.fail("option " + key + " is out of range; legal is " + legalText());
    return number;
  };
  std::visit(Overloaded{[&](const Member<double>& member)
                        {
                          expect(StoredType::Number);
                          member(group) = legal(in.number<double>());
                        },
                        [&](const Member<std::optional<double>>& member)
                        {
                          if (type == StoredType::Empty)
                            member(group) = std::nullopt;
                          else
                          {
                            expect(StoredType::Number);
                            member(group) = legal(in.number<double>());
                          }
                        },
                        [&](const Member<uint32_t>& member)
                        {
                          expect(StoredType::Unsigned);
                          member(group) = legal(in.number<uint32_t>());
                        },
                        [&](const Member<std::optional<uint32_t>>& member)
                        {
                          if (type == StoredType::Empty)
                            member(group) = std::nullopt;
                          else
                          {
                            expect(StoredType::Unsigned);
                            member(group) = legal(in.number<uint32_t>());
                          }
                        },
                        [&](const Member<int>& member)
                        {
                          expect(StoredType::Signed);
                          member(group) = legal(in.number<int32_t>());
                        },
                        [&](const Member<bool>& member)
                        {
                          expect(StoredType::Flag);
                          member(group) = in.number<bool>();
                        },
                        [&](const Member<std::string>& member)
                        {
                          expect(StoredType::Text);
                          member(group) = in.text();
                        },
                        [&](const Choice& choice)
                        {
                          expect(StoredType::Choice);
                          const std::string name = in.text();
                          const auto found = std::find(choice.names.begin(), choice.names.end(), name);
                          if (found == choice.names.end())
                            in.fail("option " + key + " is " + quoted(printable(name)) + "; legal is " +
                                    legalText());
                          choice.set(group, static_cast<int>(found - choice.names.begin()));
                        }},
             access);
}

OptionTable& OptionTable::onlyWhere(const std::vector<std::string>& keys, const Option::AnyOf& conditions)
{
  for (Option& option : options_)
    if (std::find(keys.begin(), keys.end(), option.key) != keys.end())
      option.conditions.push_back(conditions);
  return *this;
}

const Option* OptionTable::find(const std::string& key) const
{
  for (const Option& option : options_)
    if (lower(option.key) == lower(key)) return &option;
  return nullptr;
}

const Option& OptionTable::require(const std::string& key) const
{
  if (const Option* option = find(key)) return *option;
  std::vector<std::string> known;
  for (const Option& option : options_) known.push_back(option.key);
  throw std::invalid_argument("unknown option " + quoted(name_ + "." + key) + "; the nearest one is " +
                              quoted(name_ + "." + nearestOf(key, known)));
}

void TOptionGroup::loadFromConfigFile(const mrpt::config::CConfigFileBase& source, const std::string& section)
{
  const OptionTable& table = optionTable();
  const std::vector<std::string> foreign = foreignFlags();
  const std::vector<std::string> keys = keysOf(source, section, table);

  ByteWriter before;
  write(before);
  try
  {
    for (const std::string& key : keys)
    {
      const std::string text = withoutComment(source.read_string(section, key, ""));
      if (const Option* option = table.find(key))
      {
        try
        {
          option->parse(*this, text);
        }
        catch (const std::invalid_argument& error)
        {
          throw std::invalid_argument(
              withoutBrackets(place(table.name(), option->key, text, section, source) + " " + error.what()));
        }
        continue;
      }
      const bool isForeign =
          std::any_of(foreign.begin(), foreign.end(),
                      [&](const std::string& other) { return lower(other) == lower(key); });
      if (isForeign && toFlag(text)) continue;
      if (isForeign)
        throw std::invalid_argument(withoutBrackets(place(table.name(), key, text, section, source) +
                                                    " is neither yes nor no; legal is " + kLegalFlag));
      std::vector<std::string> known = foreign;
      for (const Option& option : table.options()) known.push_back(option.key);
      throw std::invalid_argument(withoutBrackets("unknown option " + quoted(key) + " in section " +
                                                  quoted(section) + " of " + nameOf(source) +
                                                  "; the nearest one is " + quoted(nearestOf(key, known))));
    }
    try
    {
      validate();
    }
    catch (const std::invalid_argument& error)
    {
      throw std::invalid_argument(
          withoutBrackets("section " + quoted(section) + " of " + nameOf(source) + ": " + error.what()));
    }
  }
  catch (...)
  {
    ByteReader reader(before.bytes());
    read(reader);
    throw;
  }
}

void TOptionGroup::saveToConfigFile(mrpt::config::CConfigFileBase& target, const std::string& section) const
{
  constexpr int kNotPadded = -1;
  constexpr int kTextWidth = 10;
  for (const Option& option : optionTable().options())
  {
    const std::string text = option.textOf(*this);
    const bool isText = std::holds_alternative<Option::Member<std::string>>(option.access);
    if (text.empty() && !isText) continue;
    const std::string unit = option.unit.empty() ? "" : " [" + option.unit + "]";
    // Keys are not padded: a configuration in memory would have the spaces in their names.
    target.write(section, option.key, text, kNotPadded, kTextWidth, option.doc + unit);
  }
}

void TOptionGroup::dumpToTextStream(std::ostream& out) const
{
  out << "[" << optionTable().name() << "]\n";
  for (const Option& option : optionTable().options())
  {
    std::string text = option.textOf(*this);
    if (text.empty()) text = option.emptyText.empty() ? "(none)" : option.emptyText;
    char line[96];
    std::snprintf(line, sizeof(line), "%-34s = ", option.key.c_str());
    out << line << text;
    if (!option.unit.empty() && text != option.emptyText) out << " " << option.unit;
    out << "\n";
  }
}

void TOptionGroup::write(ByteWriter& out) const
{
  const auto& options = optionTable().options();
  out.number(static_cast<uint32_t>(options.size()));
  for (const Option& option : options)
  {
    out.text(option.key);
    option.write(*this, out);
  }
}

void TOptionGroup::read(ByteReader& in)
{
  const auto count = in.number<uint32_t>();
  for (uint32_t i = 0; i < count; ++i)
  {
    const std::string key = in.text();
    const Option* option = optionTable().find(key);
    if (!option)
      in.fail("option " + quoted(printable(key)) + " of " + optionTable().name() + " is not known");
    option->read(*this, in);
  }
}

void TOptionGroup::writeToStream(mrpt::serialization::CArchive& out) const
{
  ByteWriter writer;
  write(writer);
  writePayload(out, writer.bytes());
}

void TOptionGroup::readFromStream(mrpt::serialization::CArchive& in)
{
  const std::vector<uint8_t> content = readPayload(in);
  ByteWriter before;
  write(before);
  try
  {
    ByteReader reader(content);
    read(reader);
    reader.expectEnd();
    validate();
  }
  catch (...)
  {
    ByteReader reader(before.bytes());
    read(reader);
    throw;
  }
}

bool TOptionGroup::sameOptions(const TOptionGroup& other) const
{
  ByteWriter here;
  ByteWriter there;
  write(here);
  other.write(there);
  return here.bytes() == there.bytes();
}

std::string withoutComment(const std::string& text)
{
  constexpr const char* kSpaces = " \t\r\n";
  size_t end = text.size();
  for (size_t i = 0; i < text.size(); ++i)
  {
    const bool opens = text[i] == '#' || text[i] == ';' || text.compare(i, 2, "//") == 0;
    const bool apart = i == 0 || text[i - 1] == ' ' || text[i - 1] == '\t';
    if (opens && apart)
    {
      end = i;
      break;
    }
  }
  const std::string kept = text.substr(0, end);
  const size_t first = kept.find_first_not_of(kSpaces);
  if (first == std::string::npos) return {};
  return kept.substr(first, kept.find_last_not_of(kSpaces) - first + 1);
}

std::string withoutBrackets(std::string message)
{
  std::replace(message.begin(), message.end(), '[', '(');
  std::replace(message.begin(), message.end(), ']', ')');
  return message;
}

bool hasKey(const mrpt::config::CConfigFileBase& source, const std::string& section, const std::string& key)
{
  const std::string absent = "\x01";  // no text of an .ini file
  return source.read_string(section, key, absent) != absent;
}

std::string nameOf(const mrpt::config::CConfigFileBase& source)
{
  const auto* file = dynamic_cast<const mrpt::config::CConfigFile*>(&source);
  const std::string name = file ? file->getAssociatedFile() : std::string();
  return name.empty() ? "the configuration" : name;
}

}  // namespace lamap
