import type {SceneChange} from "../protocol/messages";

/// What has been scraped off a scene's objects, in whatever order the changes come.  Another run of
/// the server means that the scene is whole again.
export class Remains {
  private serverRun = "";
  private readonly triangles = new Map<number, Set<number>>();
  private readonly leaves = new Map<number, Set<number>>();

  /// True where the change belongs to another run than those before it: all of them are void.
  apply(change: SceneChange): boolean {
    const anew = this.serverRun !== "" && change.serverRun !== this.serverRun;
    if (anew) this.reset();
    this.serverRun = change.serverRun;
    addAll(this.triangles, change.objectIndex, change.triangles);
    addAll(this.leaves, change.objectIndex, [change.leaf]);
    return anew;
  }

  /// True where there was something to forget.
  startRun(serverRun: string): boolean {
    if (this.serverRun === "" || serverRun === this.serverRun) return false;
    this.reset();
    this.serverRun = serverRun;
    return true;
  }

  trianglesOf(object: number): ReadonlySet<number> {
    return this.triangles.get(object) ?? new Set();
  }
  leavesOf(object: number): ReadonlySet<number> {
    return this.leaves.get(object) ?? new Set();
  }

  private reset(): void {
    this.triangles.clear();
    this.leaves.clear();
  }
}

function addAll(sets: Map<number, Set<number>>, key: number, values: readonly number[]): void {
  let set = sets.get(key);
  if (!set) sets.set(key, (set = new Set()));
  for (const value of values) set.add(value);
}
