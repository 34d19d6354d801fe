// What the help of lamap shows runs as it stands, and shells complete its command lines.
#include <gtest/gtest.h>

#include <sstream>

#include "program.h"

namespace
{
using namespace lamap;

/// Command lines for a shell, in the folder of the test, that finds the program by its name.
class ShellCommands : public test::CommandLine
{
 protected:
  /// @return exit code
  int runInShell(const std::string& line)
  {
    const std::string bin = std::filesystem::path(LAMAP_PROGRAM).parent_path().string();
    folder_.write("line.sh",
                  "cd '" + folder_.path() + "' || exit 99\nPATH='" + bin + "':$PATH\n" + line + "\n");
    const std::string in = folder_.path();
    const int status =
        std::system(("bash " + in + "/line.sh > " + in + "/out 2> " + in + "/err < /dev/null").c_str());
    out_ = test::fileContent(folder_ / "out");
    err_ = test::fileContent(folder_ / "err");
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// The examples at the end of a command's help.
  std::vector<std::string> examplesOf(const std::string& command)
  {
    EXPECT_EQ(runInShell("lamap " + command + " --help"), 0) << err_;
    std::istringstream help(out_);
    std::vector<std::string> examples;
    bool begun = false;
    for (std::string line; std::getline(help, line);)
    {
      begun = begun || line == "Examples:";
      if (begun && line.rfind("  lamap ", 0) == 0) examples.push_back(line);
    }
    return examples;
  }

  /// What bash proposes for the last word of a command line.
  std::string completionOf(const std::string& words)
  {
    EXPECT_EQ(runInShell("lamap completion bash > lamap.bash\nsource ./lamap.bash\nCOMP_WORDS=(" + words +
                         ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_lamap\necho \"${COMPREPLY[*]}\""),
              0)
        << err_;
    return out_;
  }
};

TEST_F(ShellCommands, EachExampleOfTheHelpRuns)
{
#ifdef LAMAP_SANITIZED
  GTEST_SKIP() << "sanitizers find nothing here that they do not find in the tests of each command";
#endif
  // The first ones make the logs and maps that the others read.
  for (const char* command : {"simulate", "build", "info", "query", "eval", "compare", "export", "render",
                              "thin", "tune", "run", "completion"})
  {
    const std::vector<std::string> examples = examplesOf(command);
    EXPECT_FALSE(examples.empty()) << command;
    for (const std::string& example : examples) EXPECT_EQ(runInShell(example), 0) << example << "\n" << err_;
  }
}

TEST_F(ShellCommands, BashCompletesCommandsFlagsAndWords)
{
  EXPECT_EQ(completionOf("lamap bu"), "build\n");
  EXPECT_EQ(completionOf("lamap render m.lamap.gz --view s"), "slice\n");
  EXPECT_EQ(completionOf("lamap build -m hil"), "hilbertMap\n");
  EXPECT_EQ(completionOf("lamap build --ping-s"), "--ping-separation\n");
  EXPECT_EQ(completionOf("lamap build -i lo"), "\n") << "names of files are bash's own";
  EXPECT_EQ(completionOf("lamap thin --ping-s"), "\n") << "a flag of another command";
}

TEST_F(ShellCommands, CompletionForZshNamesEachCommandAndFlag)
{
  ASSERT_EQ(run("completion zsh"), 0) << err_;
  EXPECT_EQ(out_.rfind("#compdef lamap\n", 0), 0U);
  for (const char* part : {"'render:Draw a map", "'--view[top, slice or 3d]:value:(3d slice top)'",
                           "'*-s[section.key=value", "'--json[", "'*:file:_files' ;;"})
    EXPECT_NE(out_.find(part), std::string::npos) << part;
  EXPECT_EQ(run("completion fish"), 2);
  EXPECT_NE(err_.find("'fish' is none of: bash, zsh"), std::string::npos) << err_;
}

}  // namespace
