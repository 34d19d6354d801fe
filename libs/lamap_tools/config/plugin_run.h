#pragma once

#include <string>
#include <vector>

namespace lamap::tools
{
/** Checks a configuration file of a stock application before it starts, because the application silently
 * ignores what it does not know.
 *
 * Some section must count one of this library's maps (`bgkMap_count = 1`), and everything in the sections of
 * such maps must be read by their loader; a section of such a map under the prefix of no section that counts
 * them is refused.
 * @throws std::runtime_error naming the file, what is wrong and what would be right */
void checkStockConfig(const std::string& path);

/** The plug-in: the file named by the environment variable LAMAP_PLUGIN, else the library that was built or
 * installed with this program.
 * @throws std::runtime_error if there is no such file */
[[nodiscard]] std::string pluginPath();

/** Replaces this process by a program that has the plug-in loaded (before what LD_PRELOAD names already).
 * @param command  the program, looked up in PATH, and its arguments; each that ends in .ini is checked first,
 *                 and MAP-PARTITION_CONFIG.ini before map-partition, which reads it from where it runs
 * @param check    whether to check
 * @throws std::runtime_error if a check fails or the program cannot be started; else it does not return */
[[noreturn]] void runWithPlugin(const std::vector<std::string>& command, bool check);

}  // namespace lamap::tools
