import type {SceneChange} from "../protocol/messages";

/// What has been scraped off a scene's objects, in whatever order the changes come, and whether
/// they come before or after the word that they are undone.
export class Remains {
  private changes = new Map<number, SceneChange>(); // by number
  private undone = 0; // the last change that is
  private triangles = new Map<number, Set<number>>();
  private leaves = new Map<number, Set<number>>();

  apply(change: SceneChange): void {
    if (change.change <= this.undone) return;
    this.changes.set(change.change, change);
    addAll(this.triangles, change.objectIndex, change.triangles);
    addAll(this.leaves, change.objectIndex, [change.leaf]);
  }

  /// The scene has been made whole: changes up to this one are void.
  undo(lastChange: number): void {
    if (lastChange <= this.undone) return;
    const later = [...this.changes.values()].filter(({change}) => change > lastChange);
    this.clear();
    this.undone = lastChange;
    for (const change of later) this.apply(change);
  }

  /// Another server's: nothing is known of it.
  clear(): void {
    this.changes = new Map();
    this.undone = 0;
    this.triangles = new Map();
    this.leaves = new Map();
  }

  get isWhole(): boolean {
    return this.changes.size === 0;
  }
  trianglesOf(object: number): ReadonlySet<number> {
    return this.triangles.get(object) ?? new Set();
  }
  leavesOf(object: number): ReadonlySet<number> {
    return this.leaves.get(object) ?? new Set();
  }
}

function addAll(sets: Map<number, Set<number>>, key: number, values: readonly number[]): void {
  let set = sets.get(key);
  if (!set) sets.set(key, (set = new Set()));
  for (const value of values) set.add(value);
}
