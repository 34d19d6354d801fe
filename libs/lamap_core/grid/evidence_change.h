#pragma once

#include <lamap_core/grid/evidence.h>
#include <lamap_core/grid/octant_rule.h>
#include <lamap_core/math/workers.h>

#include <vector>

namespace lamap
{
/** A change of evidence that is prepared beside it: what may fail, fails before anything is changed.
 *
 * Blocks are prepared by several threads; their number changes no bit. A change that goes
 * without commit() leaves the evidence as it was. The evidence must stay where it is, and nobody may read or
 * change it in the meantime. */
class EvidenceChange
{
 public:
  /** Adds evidence of the same shape and kind.
   * @throws std::overflow_error if a sum would pass its limit: see addSums() */
  [[nodiscard]] static EvidenceChange addition(Evidence& to, Evidence&& added, const RuleForBlock& ruleFor,
                                               const Workers& workers);
  [[nodiscard]] static EvidenceChange addition(Evidence& to, const Evidence& added,
                                               const RuleForBlock& ruleFor, const Workers& workers);
  /// Puts the blocks of other evidence in the place of those named. @param by holds none but these
  [[nodiscard]] static EvidenceChange replacement(Evidence& of, const std::vector<BlockIndex>& blocks,
                                                  Evidence&& by);

  EvidenceChange(EvidenceChange&&) noexcept = default;
  EvidenceChange& operator=(EvidenceChange&&) = delete;
  ~EvidenceChange();

  void commit() noexcept;

 private:
  /// What becomes of one block.
  struct Item
  {
    explicit Item(const BlockIndex& place) : index(place) {}

    BlockIndex index;
    const EvidenceBlock* added = nullptr;
    EvidenceBlock* mine = nullptr;    ///< the added block, where it may be taken
    EvidenceBlock* target = nullptr;  ///< null: there is none yet
    EvidenceBlock replacement;
    bool isNew = false;  ///< the target is an empty block that was made to be replaced
  };

  explicit EvidenceChange(Evidence& of) : evidence_(&of) {}
  void prepareItems(const RuleForBlock& ruleFor, const Workers& workers);
  void prepare(Item& item, const OctantRule& rule, DenseBlock& dense) const;
  void makeTargets();

  Evidence* evidence_;
  std::vector<Item> items_;
  std::vector<BlockIndex> gone_;  ///< blocks that will not be there any more
};

}  // namespace lamap
