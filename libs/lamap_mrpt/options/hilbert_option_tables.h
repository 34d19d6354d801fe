#pragma once

#include <lamap_core/hilbert/options.h>
#include <lamap_mrpt/options/option_table.h>
#include <lamap_mrpt/options/shared_options.h>

// Options that both kinds of Hilbert maps have.
namespace lamap
{
/// features, gamma, cutoff, latticeSpacing, components, seed, priorPrecision. @tparam Self a group with these
/// members
template <typename Self>
OptionTable& addFeatureOptions(OptionTable& table)
{
  return table
      .add<Self>("features", &Self::features, OptionTable::Traits::oneOf({"compact", "nystroem"}),
                 "compact kernels on a lattice, or Nystroem components of the whole kernel")
      .template add<Self>("gamma", &Self::gamma, {"m^-2", {1e-6, 1e6}, "14 (compact) or 3 (nystroem)"},
                          "the kernel falls as exp(-gamma d^2)")
      .template add<Self>("cutoff", &Self::cutoff, {"", {1e-6, 0.999}},
                          "what is taken off the kernel so that it ends")
      .template add<Self>("latticeSpacing", &Self::latticeSpacing, {"m", {1e-4, 1e4}},
                          "distance between neighbouring compact kernels")
      .template add<Self>("components", &Self::components, {"", {1, 5000}},
                          "m, of nystroem features; a saved map takes time with its cube to load")
      .template add<Self>("seed", &Self::seed, {"", {0, 4294967295.0}},
                          "of the inducing points and of the order in stochastic gradient descent")
      .template add<Self>("priorPrecision", &Self::priorPrecision, {"", {1e-6, 1e6}},
                          "of each weight before any data: the L2 penalty")
      .onlyWhere({"components"}, {{"features", {"nystroem"}}})
      .onlyWhere({"seed"}, {{"features", {"nystroem"}}, {"solver", {"sgdL1", "sgdL2"}}});
}

/// trainingPoints, freeMargin, freeResolution, hitWeight, freeWeight. @tparam Self a group with these members
template <typename Self>
OptionTable& addSamplingOptions(OptionTable& table)
{
  return table
      .add<Self>("trainingPoints", &Self::trainingPoints, OptionTable::Traits::oneOf({"cells", "points"}),
                 "hit and free cells of a scan once each, or every hit and free sample where it is")
      .template add<Self>("freeMargin", &Self::freeMargin, {"m", {0, kMetresMost}},
                          "the free sample nearest to a hit is so far before it")
      .template add<Self>("freeResolution", &Self::freeResolution, {"m", {1e-3, kMetresMost}},
                          "distance between free samples on a ray")
      .template add<Self>("hitWeight", &Self::hitWeight, {"", {0, 1e3, false}}, "weight of a hit")
      .template add<Self>("freeWeight", &Self::freeWeight, {"", {0, 1e3}},
                          "weight of a free point; 0: no free points");
}

/// iterations, alpha, epochs. @tparam Self a group with these members
template <typename Self>
OptionTable& addSolverOptions(OptionTable& table)
{
  return table
      .add<Self>("iterations", &Self::iterations, {"", {1, 1e5}, "10 (incremental) or 25"},
                 "of lbfgs, at most")
      .template add<Self>("alpha", &Self::alpha, {"", {1e-12, 1e6}}, "penalty of sgd")
      .template add<Self>("epochs", &Self::epochs, {"", {1, 1e5}}, "passes of sgd over the points")
      .onlyWhere({"iterations"}, {{"solver", {"lbfgs"}}})
      .onlyWhere({"alpha", "epochs"}, {{"solver", {"sgdL1", "sgdL2"}}});
}

}  // namespace lamap
