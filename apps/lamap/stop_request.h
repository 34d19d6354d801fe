#pragma once

namespace lamap::app
{
/// From now on SIGINT and SIGTERM ask for a stop, which stopRequested() tells; a second one ends the program
/// at once.
void catchStopSignals();

[[nodiscard]] bool stopRequested();

}  // namespace lamap::app
