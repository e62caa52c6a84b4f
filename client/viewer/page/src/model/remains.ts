import type {SceneChange, SolidBlock} from "../protocol/messages";
import {countOf, latticeOf, readBlock, Solid} from "./solid";

/// What has been scraped off a scene's objects, or cut, in whatever order the changes come, and
/// whether they come before or after the word that they are undone.
export class Remains {
  private changes = new Map<number, SceneChange>(); // by number
  private undone = 0; // the last change that is
  private triangles = new Map<number, Set<number>>();
  private leaves = new Map<number, Set<number>>();
  private solids = new Map<number, Solid>(); // by object

  apply(change: SceneChange): void {
    if (change.change <= this.undone) return;
    this.changes.set(change.change, change);
    addAll(this.triangles, change.objectIndex, change.triangles);
    addAll(this.leaves, change.objectIndex, [change.leaf]);
  }

  /// @return false where it is damaged, and nothing is taken of it
  cut(of: SolidBlock): boolean {
    if (of.change <= this.undone) return true;
    const lattice = latticeOf(of);
    const block = readBlock(of);
    if (!lattice || !block || of.block >= countOf(lattice)) return false;
    let solid = this.solids.get(of.objectIndex);
    if (!solid) this.solids.set(of.objectIndex, (solid = new Solid(lattice)));
    if (lattice.blocks.some((count, axis) => count !== solid.lattice.blocks[axis])) return false;
    solid.set(of.block, block);
    return true;
  }

  /// The scene has been made whole: changes up to this one are void.
  undo(lastChange: number): void {
    if (lastChange <= this.undone) return;
    const later = [...this.changes.values()].filter(({change}) => change > lastChange);
    const {solids} = this;
    this.clear();
    this.undone = lastChange;
    for (const solid of solids.values()) solid.undo(lastChange);
    this.solids = solids;
    for (const change of later) this.apply(change);
  }

  /// Another server's: nothing is known of it.
  clear(): void {
    this.changes = new Map();
    this.undone = 0;
    this.triangles = new Map();
    this.leaves = new Map();
    this.solids = new Map();
  }

  get isWhole(): boolean {
    return this.changes.size === 0 && [...this.solids.values()].every(({blocks}) => !blocks.size);
  }
  trianglesOf(object: number): ReadonlySet<number> {
    return this.triangles.get(object) ?? new Set();
  }
  leavesOf(object: number): ReadonlySet<number> {
    return this.leaves.get(object) ?? new Set();
  }
  solidOf(object: number): Solid | undefined {
    return this.solids.get(object);
  }
}

function addAll(sets: Map<number, Set<number>>, key: number, values: readonly number[]): void {
  let set = sets.get(key);
  if (!set) sets.set(key, (set = new Set()));
  for (const value of values) set.add(value);
}
