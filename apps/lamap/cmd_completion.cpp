#include <string>
#include <vector>

#include "command_line.h"

namespace lamap::app
{
namespace
{
enum class Shell
{
  Bash,
  Zsh
};

/// An option of a command, as shells see it.
struct ShellOption
{
  std::vector<std::string> flags;  ///< with their dashes
  std::string description;
  bool takesValue = false;
  bool isRepeated = false;
  std::vector<std::string> words;  ///< its legal values, if they are known; files otherwise
};

std::vector<std::string> wordsOf(CLI::Option& option)
{
  if (option.check_lname("map")) return {"bgkMap", "gpMap", "hilbertMap", "octoMap", "overlappingHilbertMap"};
  try
  {
    return legalWords(*option.get_validator(0));
  }
  catch (const CLI::OptionNotFound&)
  {
    return {};
  }
}

std::vector<ShellOption> optionsOf(CLI::App& command)
{
  std::vector<ShellOption> options;
  for (CLI::Option* option : command.get_options())
  {
    ShellOption described;
    for (const std::string& name : option->get_snames()) described.flags.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) described.flags.push_back("--" + name);
    if (described.flags.empty()) continue;  // a positional argument
    described.description = option->get_description();
    described.takesValue = option->get_items_expected_max() > 0;
    described.isRepeated = option->get_expected_max() > 1;
    described.words = wordsOf(*option);
    options.push_back(std::move(described));
  }
  return options;
}

std::string separated(const std::vector<std::string>& words, const std::string& separator)
{
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : separator) + word;
  return all;
}

void printForBash(CLI::App& app, std::ostream& out)
{
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  out << "# Completion of lamap for bash: source it, or save it as\n"
         "# ~/.local/share/bash-completion/completions/lamap\n"
         "_lamap()\n{\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words\n"
         "  if [ \"$COMP_CWORD\" = 1 ]; then\n"
         "    words='"
      << separated(names, " ") << " --help --version'\n"
      << "  else\n    case ${COMP_WORDS[1]}:$before in\n";
  std::string flags;
  for (CLI::App* command : app.get_subcommands({}))
  {
    std::vector<std::string> all;
    for (const ShellOption& option : optionsOf(*command))
    {
      all.insert(all.end(), option.flags.begin(), option.flags.end());
      if (option.words.empty()) continue;
      for (const std::string& flag : option.flags)
        out << "      " << command->get_name() << ":" << flag << ") words='" << separated(option.words, " ")
            << "' ;;\n";
    }
    flags += "          " + command->get_name() + ") words='" + separated(all, " ") + "' ;;\n";
  }
  out << "      *)\n"
         "        # After a program's name, its own arguments follow.\n"
         "        [[ $current == -* ]] || return\n"
         "        case ${COMP_WORDS[1]} in\n"
      << flags
      << "        esac ;;\n"
         "    esac\n  fi\n"
         "  # Without words, bash completes names of files.\n"
         "  [ -z \"$words\" ] || mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
         "}\n"
         "complete -o default -F _lamap lamap\n";
}

/// A text within quotes, of which zsh would take some characters for its own.
std::string forZsh(const std::string& text)
{
  std::string safe;
  for (const char c : text)
  {
    if (c == '\'')
      safe += "'\\''";
    else
      safe += (c == '[' || c == ']' || c == ':' || c == '\\' ? "\\" : "") + std::string(1, c);
  }
  return safe;
}

void printForZsh(CLI::App& app, std::ostream& out)
{
  out << "#compdef lamap\n"
         "# Completion of lamap for zsh: save it as _lamap in a folder of $fpath.\n"
         "local -a commands\ncommands=(\n";
  for (const CLI::App* command : app.get_subcommands({}))
    out << "  '" << command->get_name() << ":" << forZsh(command->get_description()) << "'\n";
  out << ")\n"
         "if (( CURRENT == 2 )); then\n"
         "  _describe -t commands 'command of lamap' commands\n"
         "  return\n"
         "fi\n"
         "local command=$words[2]\n"
         "shift words\n"
         "(( CURRENT-- ))\n"
         "case $command in\n";
  for (CLI::App* command : app.get_subcommands({}))
  {
    out << "  " << command->get_name() << ")\n    _arguments \\\n";
    for (const ShellOption& option : optionsOf(*command))
    {
      const std::string value =
          !option.takesValue ? ""
                             : ":value:" + (option.words.empty() ? std::string("_files")
                                                                 : "(" + separated(option.words, " ") + ")");
      for (const std::string& flag : option.flags)
        out << "      '" << (option.isRepeated ? "*" : "") << flag << "[" << forZsh(option.description) << "]"
            << value << "' \\\n";
    }
    out << "      '*:file:_files' ;;\n";
  }
  out << "esac\n";
}

struct CompletionArguments
{
  Shell shell = Shell::Bash;
};
}  // namespace

void addCompletion(CLI::App& app, Action& action)
{
  auto arguments = std::make_shared<CompletionArguments>();
  CLI::App* const command =
      app.add_subcommand("completion", "Print what a shell completes lamap's command lines by");
  command->add_option("shell", arguments->shell, "bash or zsh")
      ->required()
      ->transform(oneOf<Shell>({{"bash", Shell::Bash}, {"zsh", Shell::Zsh}}));
  command->callback(
      [&app, &action, arguments]
      {
        action = [&app, arguments]
        {
          if (arguments->shell == Shell::Bash)
            printForBash(app, results());
          else
            printForZsh(app, results());
          return 0;
        };
      });
}

}  // namespace lamap::app
