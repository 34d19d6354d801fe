#include <lamap_core/grid/evidence_change.h>

#include <tbb/enumerable_thread_specific.h>

#include <utility>

namespace lamap
{
namespace
{
/// Adds all cells of a packed block.
void addTo(DenseBlock& dense, const BlockShape& shape, SumKind kind, const EvidenceBlock& added)
{
  added.visitLeaves(shape,
                    [&](uint32_t first, uint32_t count, const CellSums& sums)
                    {
                      for (uint32_t offset = first; offset < first + count; ++offset)
                      {
                        const bool isNew = !dense.isObserved(offset);
                        dense.set(offset, isNew ? sums : addSums(kind, dense.at(offset), sums));
                      }
                    });
}
}  // namespace

EvidenceChange EvidenceChange::addition(Evidence& to, Evidence&& added, const RuleForBlock& ruleFor,
                                        const Workers& workers)
{
  EvidenceChange change(to);
  change.items_.reserve(added.blockCount());
  added.forEachBlock(
      [&](const BlockIndex& index, EvidenceBlock& block)
      {
        if (block.empty()) return;
        Item& item = change.items_.emplace_back(index);
        item.added = &block;
        item.mine = &block;
      });
  change.prepareItems(ruleFor, workers);
  return change;
}

EvidenceChange EvidenceChange::addition(Evidence& to, const Evidence& added, const RuleForBlock& ruleFor,
                                        const Workers& workers)
{
  EvidenceChange change(to);
  change.items_.reserve(added.blockCount());
  added.forEachBlock(
      [&](const BlockIndex& index, const EvidenceBlock& block)
      {
        if (!block.empty()) change.items_.emplace_back(index).added = &block;
      });
  change.prepareItems(ruleFor, workers);
  return change;
}

EvidenceChange EvidenceChange::replacement(Evidence& of, const std::vector<BlockIndex>& blocks, Evidence&& by)
{
  EvidenceChange change(of);
  for (const BlockIndex& index : blocks)
  {
    const EvidenceBlock* const old = of.find(index);
    std::shared_ptr<EvidenceBlock> fresh = by.take(index);
    if (fresh == nullptr)
    {
      if (old != nullptr) change.gone_.push_back(index);
      continue;
    }
    Item& item = change.items_.emplace_back(index);
    item.target = old;
    item.replacement = std::move(fresh);
    change.findLayers(item);
  }
  change.makeTargets();
  return change;
}

EvidenceChange::~EvidenceChange()
{
  for (const Item& item : items_)
  {
    if (item.isCounted) evidence_->extent()->shrink(item.index, item.both(), item.before);
    if (item.isNew) evidence_->erase(item.index);
  }
}

void EvidenceChange::prepareItems(const RuleForBlock& ruleFor, const Workers& workers)
{
  tbb::enumerable_thread_specific<DenseBlock> dense([&] { return DenseBlock(evidence_->shape()); });
  workers.forEach(items_.size(),
                  [&](size_t i)
                  {
                    Item& item = items_[i];
                    item.target = evidence_->find(item.index);
                    prepare(item, ruleFor(item.index), dense.local());
                    findLayers(item);
                  });
  makeTargets();
}

void EvidenceChange::prepare(Item& item, const OctantRule& rule, DenseBlock& dense) const
{
  const BlockShape& shape = evidence_->shape();
  const SumKind kind = evidence_->kind();
  item.replacement = std::make_shared<EvidenceBlock>();
  EvidenceBlock& sum = *item.replacement;
  // Where nothing is held once before or after, as in most blocks near surfaces, there is nothing to unpack.
  const bool isPlain =
      rule.pruning != Pruning::State && !item.added->pruned() && !item.added->wide() &&
      (item.target == nullptr || (kind == SumKind::Counts && item.added->isPlainFor(*item.target)));
  if (isPlain)
  {
    sum = item.mine != nullptr ? std::move(*item.mine) : *item.added;
    if (item.target != nullptr) sum.addPlain(shape, *item.target);
    if (rule.pruning == Pruning::None || !sum.hasEqualOctant(shape)) return;
    sum.unpack(shape, dense);
  }
  else
  {
    dense.clear();
    if (item.target != nullptr) item.target->unpack(shape, dense);
    addTo(dense, shape, kind, *item.added);
  }
  sum.pack(shape, dense, rule.merger);
}

void EvidenceChange::findLayers(Item& item) const
{
  if (evidence_->extent() == nullptr) return;
  const BlockShape& shape = evidence_->shape();
  if (item.target != nullptr) item.before = item.target->layers(shape);
  item.after = item.replacement->layers(shape);
}

/// Makes the blocks that are not there yet, empty.
void EvidenceChange::makeTargets()
{
  for (Item& item : items_)
  {
    if (CellExtent* extent = evidence_->extent())
    {
      extent->grow(item.index, item.before, item.both());
      item.isCounted = true;
    }
    if (item.target != nullptr) continue;
    (void)evidence_->findOrCreate(item.index);
    item.isNew = true;
  }
}

void EvidenceChange::commit() noexcept
{
  CellExtent* const extent = evidence_->extent();
  for (Item& item : items_)
  {
    evidence_->replace(item.index, std::move(item.replacement));
    if (extent != nullptr) extent->shrink(item.index, item.both(), item.after);
  }
  for (const BlockIndex& index : gone_)
  {
    if (extent != nullptr) extent->shrink(index, evidence_->find(index)->layers(evidence_->shape()), {});
    evidence_->erase(index);
  }
  items_.clear();
  gone_.clear();
}

}  // namespace lamap
