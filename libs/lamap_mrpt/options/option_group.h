#pragma once

#include <lamap_core/options/option_table.h>
#include <lamap_mrpt/files/byte_stream.h>
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/config/CLoadableOptions.h>

#include <string>
#include <vector>

namespace lamap
{
/** A group of options that loads, saves and prints itself as MRPT's groups do, but strictly, as its
 * OptionTable describes. Derive from OptionGroup. */
class TOptionGroup : public mrpt::config::CLoadableOptions
{
 public:
  [[nodiscard]] virtual const OptionTable& optionTable() const = 0;
  /// This group as its table takes it, for Option::textOf() and parse().
  virtual operator AnyOptions() = 0;
  virtual operator ConstAnyOptions() const = 0;

  /// @throws std::invalid_argument if an option is illegal, or if they contradict each other; lengths in
  /// cells are left to those who know the resolution.
  virtual void validate() const { optionTable().validate(*this, std::nullopt); }

  /** Loads what the section holds; options that it does not name keep what they have. Nothing changes on an
   * error.
   * @throws std::invalid_argument naming file, section, key and text, and what would be right: for a key that
   * is not an option (keys() of optionTable() are), a text that is not of the option's type, or out of its
   * range. */
  void loadFromConfigFile(const mrpt::config::CConfigFileBase& source, const std::string& section) override;

  /// Writes every option with its meaning as a comment; lengths that are left empty are not written.
  void saveToConfigFile(mrpt::config::CConfigFileBase& target, const std::string& section) const override;
  void dumpToTextStream(std::ostream& out) const override;

  /// Writes every option, exactly.
  void write(ByteWriter& out) const;
  /** Options that the content does not hold keep what they have.
   * @throws std::runtime_error if it holds an option that is not known here, or one that is not legal. */
  void read(ByteReader& in);

  /// Whether both have the same options with the same content.
  [[nodiscard]] bool sameOptions(const TOptionGroup& other) const { return optionTable().same(*this, other); }

 protected:
  /// Keys with a yes or no that other code reads from the section of this group.
  [[nodiscard]] virtual std::vector<std::string> foreignFlags() const { return {}; }
};

/// A group whose options are members of its own. @tparam Self the group, which its table describes
template <typename Self>
class OptionGroup : public TOptionGroup
{
 public:
  operator AnyOptions() override { return AnyOptions(static_cast<Self*>(this)); }
  operator ConstAnyOptions() const override { return ConstAnyOptions(static_cast<const Self*>(this)); }
};

/// What an option holds, for reports.
struct OptionValue
{
  std::string section;  ///< e.g. "insertOpts"
  std::string key;
  OptionContent content;
  std::string text;  ///< the same as text; a length that is left empty: e.g. "2 cells"
  std::string unit;
};

/// Removes what follows //, # or ; at the start or after a space, and surrounding spaces.
[[nodiscard]] std::string withoutComment(const std::string& text);

/** A message that MRPT does not truncate: when it wraps an exception, it takes everything before the first ]
 * for a source location. */
[[nodiscard]] std::string withoutBrackets(std::string message);

/** Whether a section has a key. Asks for it by name: MRPT's CConfigFilePrefixer (map-partition reads through
 * one) lists the keys of another section, as keyExists() does then. */
[[nodiscard]] bool hasKey(const mrpt::config::CConfigFileBase& source, const std::string& section,
                          const std::string& key);

/// The file that was loaded, or "the configuration".
[[nodiscard]] std::string nameOf(const mrpt::config::CConfigFileBase& source);

}  // namespace lamap
