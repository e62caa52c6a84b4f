import type {SceneModel} from "./bundle";
import type {SolidBlock} from "../protocol/messages";
import {countOf, latticeOf, readBlock, Solid} from "./solid";

/// What has been cut of a scene's objects.  Blocks may come in any order, and before or after the
/// message that undoes them.
export class Remains {
  private undone = 0; // the last change that was undone
  private solids = new Map<number, Solid>(); // by object

  /// @return false if the block is damaged and was ignored
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

  /// The scene was restored: changes up to this one are void.
  undo(lastChange: number): void {
    if (lastChange <= this.undone) return;
    this.undone = lastChange;
    for (const solid of this.solids.values()) solid.undo(lastChange);
  }

  /// A new server: nothing is known of its scene.
  clear(): void {
    this.undone = 0;
    this.solids = new Map();
  }

  get isWhole(): boolean {
    return [...this.solids.values()].every(({blocks}) => !blocks.size);
  }
  solidOf(object: number): Solid | undefined {
    return this.solids.get(object);
  }
}

/// Returns what burs have removed of each tissue of a scene, which may have several materials
/// [mm³].
export function removedByTissue({objects}: SceneModel, remains: Remains): Map<string, number> {
  const removed = new Map<string, number>();
  objects.forEach(({tissues}, object) => {
    const solid = remains.solidOf(object);
    tissues.forEach((name, material) => {
      removed.set(name, (removed.get(name) ?? 0) + (solid?.removedMm3(material) ?? 0));
    });
  });
  return removed;
}
