#pragma once

#include <stdexcept>

namespace lamap::tools
{
/// The command line itself is wrong (an unknown map name, a setting of the wrong form): the program ends with
/// 2, not 1.
class UsageError : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace lamap::tools
