import type {SceneChange} from "../protocol/messages";

/// What has been scraped off a scene's objects, in whatever order the changes come.
export class Remains {
  private readonly triangles = new Map<number, Set<number>>();
  private readonly leaves = new Map<number, Set<number>>();

  apply(change: SceneChange): void {
    addAll(this.triangles, change.objectIndex, change.triangles);
    addAll(this.leaves, change.objectIndex, [change.leaf]);
  }

  /// Whole again.
  clear(): void {
    this.triangles.clear();
    this.leaves.clear();
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
