#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/math/pose.h"
#include "server/physics/leaf_pair.h"
#include "server/physics/limits.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/surface/body_meshes.h"
#include "server/physics/surface/separating_plane.h"
#include "server/physics/surface/separation_front.h"
#include "server/physics/surface/triangle_distance.h"

namespace palpate {

/// Keeps the meshes of tool and objects apart in one sub-step.
///
/// The invariant: one plane separates each pair of triangles where the sub-step begins and where it
/// ends, so the straight way between is free too.  At the end its gap is kFree at least, or no less
/// than the pair's distance was (but for kRounding).  Patches that such a plane separates are not
/// looked into.  The zero step changes no gap: it is always free.
///
/// Rows come on violation.  A pair of triangles that no plane separates at the end of a trial gives
/// rows: corners of the one stay above a plane of the other.  A row asks for kSeparation; of a pair
/// that is nearer, for kRegain more than it has.
///
/// Which plane: where the nearest features touch within their normal cones, the plane across the
/// nearest points, fixed to the side that has the face or edge; of two edges that cross, the plane
/// of both, which turns with them.  Out of the cones a neighbour is nearer, and the touch is the
/// neighbour's: its plane keeps this pair apart too, or else a face of either mesh.
/// Drawings: README.md, and ../surface/README.md.
///
/// Real-time but for construction: no allocation, lock, log or clock.  Deterministic.
class MeshContact {
 public:
  /// @param max_rows  of the ContactRows that it is going to fill.
  MeshContact(const MeshWithTree& tool, const MeshWithTree& objects, int max_rows);

  /// Begins a sub-step from `from`: updates the front, and adds the rows of the `active` pairs that
  /// still touch: those out of their cones too, or a tool at rest would find them anew in each
  /// step, a little off.  It may look at most `most_looks` times; pairs that there are no looks
  /// left for count as not apart where their planes do not hold.
  void Begin(const Kernels& kernels, SeparationFront& front, const ToolPose& from,
             const LeafPair* active, int actives, std::int64_t most_looks,
             ContactRows& rows) noexcept;

  /// Looks at the trial [v; phi]: 0 where every pair has a plane.  Else more: a count of pairs that
  /// have none or were not looked at, for it ends with limits::mesh::kEnough that have none.  Rows
  /// of those that have none are added, or made anew where the trial breaks them.
  int Check(const Vec3& v, const Vec3& phi, ContactRows& rows) noexcept;
  /// Whether the trial is free, without rows: it ends with the first pair that has no plane.
  bool IsFree(const Vec3& v, const Vec3& phi) noexcept;

  /// Of the rows active at the trial that Check found free: takes those out whose pair does not
  /// touch there, and which another plane keeps apart.  Returns how many pairs it changed; where it
  /// is not 0, the rows are to be solved again.
  int Retract(const int* active, int actives, ContactRows& rows) noexcept;
  /// The same for rows whose direction in the configuration space is another one at the trial than
  /// where they were made, by limits::mesh::kTurned: makes them anew, once in a sub-step.
  int Relinearise(const int* active, int actives, ContactRows& rows) noexcept;

  /// Lets the active rows go whose pair does not touch at the trial: its plane is not that of a
  /// contact, and hinders the tool without a cause.  Returns how many pairs those are; 0 where the
  /// trial is where the contacts hold the tool.
  int Release(const int* active, int actives, ContactRows& rows) noexcept;
  /// Undoes the last Release.
  void PutBack(ContactRows& rows) noexcept;

  /// A ball's row goes straight past the edge or the corner that it touches: the derivative [1/m]
  /// of its normal by the ball's way round it.  Zero of other rows.
  Mat3 CurvatureOf(int row) const noexcept;
  /// How far the direction in which a ball touches at the trial has left those of the active rows,
  /// or the curvature of one has made the ball go past it [rad].
  double Turned(const int* active, int actives, const ContactRows& rows) const noexcept;

  /// Makes the rows anew, exact where the sub-step begins: each allows the zero step.
  void RelineariseAtStart(ContactRows& rows) noexcept;

  /// Rows ask for some of the separation that a pair has lost.  Where that would lift the tool
  /// against the spring a tool at rest would never stay: from here on, to the sub-step's end, they
  /// ask for what the pair has.  False where they did so before.
  bool GiveUpRegain(ContactRows& rows) noexcept;

  /// No trial is free: Accept is to leave the tool where it is.
  void Stay() noexcept;
  /// Ends the sub-step.  The tool goes to the trial that Check looked at last, which must be free;
  /// after Stay it stays.  The planes go into the front.
  void Accept() noexcept;

  /// What the sub-step has cost since Begin, in looks (limits::mesh::kMaxLooks): pairs brought up
  /// to date count as well.
  std::int64_t looks() const { return tested_ + refreshed_ / limits::mesh::kRefreshesALook; }
  /// The sub-step may look no closer: what needs it is not apart.
  bool IsExhausted() const { return looks() >= most_looks_; }
  /// More pairs are near than the sub-step may bring up to date: none of its trials is free.
  bool IsFull() const { return full_; }
  /// Whether no triangle of the tool meets one of the objects at a pose.  What lies wholly inside a
  /// closed mesh meets none.  Not real-time.
  bool IsFree(const ToolPose& at) const;

  const MeshWithTree& tool() const { return tool_; }
  const MeshWithTree& objects() const { return objects_; }

 private:
  /// A plane between a pair of triangles, and what it moves with.
  struct Plane {
    enum class Of : std::uint8_t { kNone, kObject, kTool, kEdges } of = Of::kNone;
    Vec3 n = Vec3::Zero();  ///< from object to tool; in W, of kTool in the tool's frame
    std::uint8_t tool_edge = 0, object_edge = 0;
    double sign = 1.0;  ///< kEdges: n = sign * (tool's edge x object's edge), normalised
  };
  /// A pair of triangles that the front's own plane does not keep apart.
  struct Touch {
    HullTree::Node tool, object;
    NearestPoints nearest;  ///< at the sub-step's beginning, in W
    Vec3 u;                 ///< direction between them
    double distance;        ///< the gap along u: negative where they intersect
    bool in_cone;
    Plane plane;  ///< where it has rows
    /// Once in a sub-step: two planes, or two directions, could be taken for each other in turn.
    bool retracted, relinearised;
    int row[3];  ///< of the corners, or the one row of kEdges; -1 where there is none
  };
  /// A row that Release has taken out of its touch.
  struct Released {
    Touch* touch;
    int slot;  ///< in touch->row
    int row;
    double gap;  ///< that it had [m]
  };
  /// A pair of the front that the bounds could bring together.  Its plane at the sub-step's
  /// beginning, which every trial reads, stands in planes_ at the same index.
  struct NearPair {
    HullTree::Node tool, object;
    SeparationFront::Index index;  ///< in the front
    std::int32_t touch;            ///< -1: none
    std::int32_t looked_at;        ///< closely, at this trial: then next_ has its plane there
    bool split, replaced;          ///< its plane is not the front's any more
  };
  struct Next {
    Vec3 n;
    double slack;
  };
  /// A row of a pair's plane, exact at the trial.
  struct PlaneRow {
    int slot;         ///< which of the pair's rows it is: a corner, or 3 of edges
    Vec3 n;           ///< what the gap grows by as the tool moves
    Vec3 lever;       ///< of the contact at the sub-step's beginning, from the tool's reference [m]
    Vec3 by_turning;  ///< what the gap grows by as phi grows [m]
    double before, now;  ///< gap at the sub-step's beginning and at the trial [m]
  };
  struct Corners {
    Vec3 a[3], b[3];
  };

  PatchPair PairOf(HullTree::Node tool, HullTree::Node object) const;
  double Low(HullTree::Node tool, const Vec3& n, const ToolPose& at) const;
  double High(HullTree::Node object, const Vec3& n) const;
  double TurnLoss(const Plane& plane, const Touch& touch, const Vec3& n_old,
                  const Vec3& n_new) const;
  double Gap(const NearPair& near, const Vec3& n, const ToolPose& at) const;
  bool HoldsAlong(NearPair& near, const Vec3& n, double least_old, double least_new);
  bool HoldsAcross(NearPair& near, double distance, const Plane& plane, const Touch& touch);
  Vec3 NormalAt(const Touch& touch, const Plane& plane, const ToolPose& at) const;
  bool IsSeparable(NearPair& near);
  bool TrianglesApart(NearPair& near);
  bool NeighbourHolds(NearPair& near, double distance);
  int Look(const Vec3& v, const Vec3& phi, ContactRows* rows);
  bool LookCloser(std::int32_t k, ContactRows* rows);
  bool GiveRows(NearPair& near, ContactRows& rows);
  void GiveDeferredRows(ContactRows& rows);
  Vec3 NormalOf(const NearPair& near) const;
  bool Split(std::int32_t k);
  void SetPlane(NearPair& near, const Vec3& n, double slack);
  void AddNear(SeparationFront::Index index);
  void AddNear(const SeparationFront::Index* index, int count, double way);
  void Cover(double translation, double rotation);
  void Merge();
  Corners CornersAt(HullTree::Node tool, HullTree::Node object, const ToolPose& at) const;
  Touch& TouchOf(NearPair& near);
  bool InCone(const NearPair& near, const NearestPoints& nearest, const Vec3& u,
              const ToolPose& at) const;
  template <class Visit>
  void ForEachFace(const NearPair& near, const NearestPoints& nearest, Visit visit) const;
  double Asked(double before) const;
  Plane ChoosePlane(const NearPair& near, const Touch& touch) const;
  Vec3 EdgesTurning(const Touch& touch, const Vec3& n) const;
  bool TurnSmoothed(const NearPair& near, const Touch& touch, int row, const NearestPoints& nearest,
                    const Vec3& u, ContactRows& rows);
  Vec3 SmoothedRow(const NearPair& near, const Vec3& n) const;
  int RowsOf(const NearPair& near, const Touch& touch, PlaneRow (&of)[3]) const;
  void SetRow(const NearPair& near, const PlaneRow& row, ContactRows& rows);
  bool PutRows(const NearPair& near, bool all, ContactRows& rows);
  NearPair& PairOf(const Touch& touch);
  Touch* TouchOfRow(int row);
  template <class Mend>
  int MendRows(const int* active, int actives, const ContactRows& rows, Mend mend);
  bool Retract(int row, Touch& touch, ContactRows& rows);
  Plane OtherPlane(const NearPair& near, const Touch& touch, const NearestPoints& nearest,
                   const Vec3& u) const;
  void TakeOut(Touch& touch, ContactRows& rows);

  const MeshWithTree& tool_;
  const MeshWithTree& objects_;
  const Kernels* kernels_ = &ActiveKernels();
  ToolPose from_, to_;
  Vec3 v_ = Vec3::Zero(), phi_ = Vec3::Zero();
  bool moved_ = false;
  bool full_ = false;     ///< more pairs are near than may be brought up to date
  double covered_ = 0.0;  ///< way for which near_ has all pairs [m]
  std::uint32_t substep_ = 0;
  std::int32_t trial_ = 0;  ///< of the sub-step
  std::vector<std::uint32_t>
      seen_;  ///< of each of the front's slots: the sub-step that it is near in
  std::vector<NearPair> near_;
  std::vector<Next> next_;  ///< of each of near_, the plane at the trial
  std::unique_ptr<double[], void (*)(double*)> plane_storage_;
  PlaneColumns planes_{};  ///< of each of near_
  std::vector<std::int32_t> found_;
  std::vector<std::int64_t> doubts_;
  std::vector<std::int32_t> deferred_;  ///< of near_: out of their cones
  bool touched_ = false;                ///< a pair in its cones has got rows at the trial
  std::vector<Touch> touches_;
  std::vector<std::int32_t> touch_of_row_;
  std::vector<Released> released_;
  std::vector<double> regain_;  ///< of each row: what it asks for beyond what its pair has [m]
  bool regains_ = true;
  SeparationFront* front_ = nullptr;  ///< during a sub-step
  std::int64_t tested_ = 0, refreshed_ = 0, most_looks_ = 0;
};

}  // namespace palpate
