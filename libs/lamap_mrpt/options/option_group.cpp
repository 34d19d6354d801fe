#include <lamap_mrpt/options/option_group.h>

#include <lamap_core/options/nearest_name.h>
#include <mrpt/config/CConfigFile.h>
#include <mrpt/system/string_utils.h>

#include <algorithm>
#include <ostream>
#include <stdexcept>

namespace lamap
{
namespace
{
template <typename... Cases>
struct Overloaded : Cases...
{
  using Cases::operator()...;
};
template <typename... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

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
    const auto isIt = [&](const std::string& key)
    { return mrpt::system::strCmpI(withoutComment(key), option.key); };
    if (std::none_of(listed.begin(), listed.end(), isIt) && hasKey(source, section, option.key))
      keys.push_back(option.key);
  }
  return keys;
}

void writeContent(const Option& option, const OptionContent& content, ByteWriter& out)
{
  const auto put = [&](StoredType type, auto number)
  {
    out.number(static_cast<uint8_t>(type));
    out.number(number);
  };
  const auto putText = [&](StoredType type, const std::string& text)
  {
    out.number(static_cast<uint8_t>(type));
    out.text(text);
  };
  std::visit(
      Overloaded{[&](std::monostate) { out.number(static_cast<uint8_t>(StoredType::Empty)); },
                 [&](double number) { put(StoredType::Number, number); },
                 [&](uint32_t number) { put(StoredType::Unsigned, number); },
                 [&](int32_t number) { put(StoredType::Signed, number); },
                 [&](bool flag) { put(StoredType::Flag, flag); },
                 [&](const std::string& text) { putText(StoredType::Text, text); },
                 // By name: enumerators may be reordered.
                 [&](OptionChoice choice) { putText(StoredType::Choice, option.names.at(choice.number)); }},
      content);
}

/// @throws std::runtime_error if the bytes do not hold legal content of the option
OptionContent readContent(const Option& option, ByteReader& in)
{
  const auto type = static_cast<StoredType>(in.number<uint8_t>());
  if (type == StoredType::Empty && option.mayBeEmpty) return {};
  const auto expect = [&](StoredType due)
  {
    if (type != due) in.fail("option " + option.key + " is stored with another type");
  };
  const auto legal = [&](auto number) -> OptionContent
  {
    if (!option.range.holds(static_cast<double>(number)))
      in.fail("option " + option.key + " is out of range; legal is " + option.legalText());
    return number;
  };
  switch (option.type)
  {
    case OptionType::Number:
      expect(StoredType::Number);
      return legal(in.number<double>());
    case OptionType::Unsigned:
      expect(StoredType::Unsigned);
      return legal(in.number<uint32_t>());
    case OptionType::Signed:
      expect(StoredType::Signed);
      return legal(in.number<int32_t>());
    case OptionType::Flag:
      expect(StoredType::Flag);
      return in.number<bool>();
    case OptionType::Text:
      expect(StoredType::Text);
      return in.text();
    case OptionType::Choice:
      break;
  }
  expect(StoredType::Choice);
  const std::string name = in.text();
  const auto found = std::find(option.names.begin(), option.names.end(), name);
  if (found == option.names.end())
    in.fail("option " + option.key + " is " + quoted(printable(name)) + "; legal is " + option.legalText());
  return OptionChoice{static_cast<size_t>(found - option.names.begin())};
}

/// Puts back what a group had, unless all goes well.
class Undo
{
 public:
  explicit Undo(TOptionGroup& group) : group_(group)
  {
    for (const Option& option : group.optionTable().options()) before_.push_back(option.get(group));
  }
  ~Undo()
  {
    const auto& options = group_.optionTable().options();
    for (size_t i = 0; i < before_.size(); ++i) options[i].set(group_, before_[i]);
  }
  Undo(const Undo&) = delete;
  Undo& operator=(const Undo&) = delete;
  void keep() { before_.clear(); }

 private:
  TOptionGroup& group_;
  std::vector<OptionContent> before_;
};

/// Sets what a key of a section says. @throws std::invalid_argument naming file, section, key and text
void load(TOptionGroup& group, const std::vector<std::string>& foreign,
          const mrpt::config::CConfigFileBase& source, const std::string& section, const std::string& listed)
{
  const OptionTable& table = group.optionTable();
  const std::string key = withoutComment(listed);  // MRPT pads keys that it writes into memory
  const std::string text = withoutComment(source.read_string(section, listed, ""));
  if (const Option* option = table.find(key))
  {
    try
    {
      option->parse(group, text);
    }
    catch (const std::invalid_argument& error)
    {
      throw std::invalid_argument(place(table.name(), option->key, text, section, source) + " " +
                                  error.what());
    }
    return;
  }
  if (std::any_of(foreign.begin(), foreign.end(),
                  [&](const std::string& other) { return mrpt::system::strCmpI(other, key); }))
  {
    if (flagIn(text)) return;
    throw std::invalid_argument(place(table.name(), key, text, section, source) +
                                " is neither yes nor no; legal is true or false");
  }
  std::vector<std::string> known = foreign;
  for (const Option& option : table.options()) known.push_back(option.key);
  throw std::invalid_argument("unknown option " + quoted(key) + " in section " + quoted(section) + " of " +
                              nameOf(source) + "; " + suggestionFor(key, known, "\"", "\""));
}
}  // namespace

void TOptionGroup::loadFromConfigFile(const mrpt::config::CConfigFileBase& source, const std::string& section)
{
  const std::vector<std::string> foreign = foreignFlags();
  Undo undo(*this);
  try
  {
    for (const std::string& key : keysOf(source, section, optionTable()))
      load(*this, foreign, source, section, key);
    try
    {
      validate();
    }
    catch (const std::invalid_argument& error)
    {
      throw std::invalid_argument("section " + quoted(section) + " of " + nameOf(source) + ": " +
                                  error.what());
    }
  }
  catch (const std::invalid_argument& error)
  {
    throw std::invalid_argument(withoutBrackets(error.what()));
  }
  undo.keep();
}

void TOptionGroup::saveToConfigFile(mrpt::config::CConfigFileBase& target, const std::string& section) const
{
  constexpr int kNotPadded = -1;
  constexpr int kTextWidth = 10;
  for (const Option& option : optionTable().options())
  {
    const std::string text = option.textOf(*this);
    if (text.empty() && option.type != OptionType::Text) continue;
    const std::string unit = option.unit.empty() ? "" : " [" + option.unit + "]";
    // Keys are not padded: a configuration in memory would have the spaces in their names.
    target.write(section, option.key, text, kNotPadded, kTextWidth, option.doc + unit);
  }
}

void TOptionGroup::dumpToTextStream(std::ostream& out) const
{
  constexpr size_t kKeyWidth = 34;
  out << "[" << optionTable().name() << "]\n";
  for (const Option& option : optionTable().options())
  {
    std::string text = option.textOf(*this);
    if (text.empty()) text = option.emptyText.empty() ? "(none)" : option.emptyText;
    const size_t spaces = kKeyWidth - std::min(kKeyWidth, option.key.size());
    out << option.key << std::string(spaces, ' ') << " = " << text;
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
    writeContent(option, option.get(*this), out);
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
    option->set(*this, readContent(*option, in));
  }
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
