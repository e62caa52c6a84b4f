#include "server/session/cut_union.h"

#include <string>

#include "server/physics/limits.h"

namespace palpate {

CutUnion::Line::Line(const CutUnion& all) {
  for (const CutField& cut : all.cuts_) waits.emplace_back(cut.field().lattice().block_count());
}

void CutUnion::Line::Wait(const Place& place) {
  std::vector<bool>::reference waits_already = waits[place.solid][place.block];
  if (!waits_already) line.push_back(place);
  waits_already = true;
}

CutUnion::CutUnion(std::span<const CutSolid> solids) {
  for (const CutSolid& solid : solids) {
    cuts_.emplace_back(*solid.grid, kMostGridBytes, "solid " + std::to_string(cuts_.size()));
  }
}

template <class Use>
void CutUnion::ForEachCut(const Use& use) const {
  for (std::uint32_t solid = 0; solid < cuts_.size(); ++solid) {
    const SparseField& field = cuts_[solid].field();
    for (std::uint32_t block = 0; block < field.lattice().block_count(); ++block) {
      if (field.entry(block) != SparseField::kBelow) use(Place{solid, block});
    }
  }
}

void CutUnion::Join(std::uint32_t session, bool has_all) {
  Line& line = waiting_.try_emplace(session, *this).first->second;
  if (!has_all) ForEachCut([&](const Place& place) { line.Wait(place); });
}

bool CutUnion::Take(std::uint32_t session, const CutBlock& block) {
  if (!cuts_[block.solid].Merge(block.block, block.merged())) return false;
  whole_ = false;
  for (auto& [number, line] : waiting_) {
    if (number != session) line.Wait({block.solid, block.block});
  }
  return true;
}

bool CutUnion::Give(std::uint32_t session, CutBlock& block) {
  Line& line = waiting_.at(session);
  if (line.line.empty()) return false;
  const Place place = line.line.front();
  line.line.pop_front();
  line.waits[place.solid][place.block] = false;
  block.solid = place.solid;
  block.number = ++line.given;
  CopyBlock(cuts_[place.solid].field(), place.block, block);
  return true;
}

void CutUnion::MakeWhole() {
  for (CutField& cut : cuts_) cut.MakeWhole();
  whole_ = true;
  for (auto& [session, line] : waiting_) {
    for (const Place& place : line.line) line.waits[place.solid][place.block] = false;
    line.line.clear();
  }
}

void CutUnion::SetBookmark() {
  has_bookmark_ = true;
  bookmark_.clear();
  ForEachCut([&](const Place& place) {
    CutBlock& kept = bookmark_.emplace_back();
    kept.solid = place.solid;
    CopyBlock(cuts_[place.solid].field(), place.block, kept);
  });
}

void CutUnion::GoBack() {
  constexpr std::uint32_t kNobody = 0;
  MakeWhole();
  for (const CutBlock& block : bookmark_) Take(kNobody, block);
}

}  // namespace palpate
