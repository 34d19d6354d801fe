#include <lamap_core/learning/solver_options.h>

#include <lamap_core/options/option_table.h>

namespace lamap
{
const OptionTable& DescentOptions::optionTable()
{
  static const OptionTable table =
      OptionTableOf<DescentOptions>("insertOpts")
          .add("alpha", &DescentOptions::alpha, plain().from(1e-12).to(1e6), "penalty of sgdL1 and sgdL2")
          .add("epochs", &DescentOptions::epochs, plain().from(1).to(1e5),
               "passes of sgdL1 and sgdL2 over the points")
          .onlyWhere({"alpha", "epochs"}, {{"solver", {"sgdL1", "sgdL2"}}});
  return table;
}

}  // namespace lamap
