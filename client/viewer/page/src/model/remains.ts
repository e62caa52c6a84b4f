import type {SolidBlock} from "../protocol/messages";
import {countOf, latticeOf, readBlock, Solid} from "./solid";

/// What has been cut of a scene's objects, in whatever order the blocks come, and whether they come
/// before or after the word that they are undone.
export class Remains {
  private undone = 0; // the last change that is
  private solids = new Map<number, Solid>(); // by object

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
    this.undone = lastChange;
    for (const solid of this.solids.values()) solid.undo(lastChange);
  }

  /// Another server's: nothing is known of it.
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
