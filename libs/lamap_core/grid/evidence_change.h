#pragma once

#include <lamap_core/grid/evidence.h>
#include <lamap_core/grid/octant_rule.h>
#include <lamap_core/math/workers.h>

#include <memory>
#include <vector>

namespace lamap
{
/** A change of evidence that is staged separately: anything that can fail fails before the evidence changes.
 *
 * Several threads prepare the blocks; their number changes no bit. A change that is destroyed without
 * commit() leaves the evidence as it was. Until then the evidence must not be moved, read or changed. */
class EvidenceChange
{
 public:
  /** Adds evidence of the same shape and kind.
   * @throws std::overflow_error if a sum would pass its limit: see addSums() */
  [[nodiscard]] static EvidenceChange addition(Evidence& to, Evidence&& added, const RuleForBlock& ruleFor,
                                               const Workers& workers);
  [[nodiscard]] static EvidenceChange addition(Evidence& to, const Evidence& added,
                                               const RuleForBlock& ruleFor, const Workers& workers);
  /// Replaces the named blocks by those of other evidence. @param by holds no other blocks
  [[nodiscard]] static EvidenceChange replacement(Evidence& of, const std::vector<BlockIndex>& blocks,
                                                  Evidence&& by);

  EvidenceChange(EvidenceChange&&) noexcept = default;
  EvidenceChange& operator=(EvidenceChange&&) = delete;
  ~EvidenceChange();

  void commit() noexcept;

 private:
  /// The change of one block.
  struct Item
  {
    explicit Item(const BlockIndex& place) : index(place) {}

    BlockIndex index;
    const EvidenceBlock* added = nullptr;
    EvidenceBlock* mine = nullptr;          ///< the added block, if it may be moved from
    const EvidenceBlock* target = nullptr;  ///< null: the block does not exist yet
    std::shared_ptr<EvidenceBlock> replacement;
    bool isNew = false;  ///< an empty block was made in its place for this change
    // Of evidence that keeps its extent: the layers of the block before the change, after it, and both.
    BlockLayers before{};
    BlockLayers after{};
    bool isCounted = false;  ///< the extent has both

    [[nodiscard]] BlockLayers both() const
    {
      return {before[0] | after[0], before[1] | after[1], before[2] | after[2]};
    }
  };

  explicit EvidenceChange(Evidence& of) : evidence_(&of) {}
  void prepareItems(const RuleForBlock& ruleFor, const Workers& workers);
  void prepare(Item& item, const OctantRule& rule, DenseBlock& dense) const;
  void findLayers(Item& item) const;
  void makeTargets();

  Evidence* evidence_;
  std::vector<Item> items_;
  std::vector<BlockIndex> gone_;  ///< blocks to be erased
};

}  // namespace lamap
