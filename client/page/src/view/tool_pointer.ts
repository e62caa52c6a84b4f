import {MathUtils, type PerspectiveCamera, Vector3} from "three";

import {say} from "../messages/say";
import {edgePlace, type Room} from "../model/edge_place";
import type {Vec3} from "../base/pose";

const kHalf = 22; // half the arrow's size [pixels], as in stage.css

/// An arrow at the picture's edge if the tool is outside; pressing it brings the tool
/// back into view.
export class ToolPointer {
  constructor(
    private readonly button: HTMLButtonElement,
    bringBack: () => void,
  ) {
    button.addEventListener("click", bringBack);
  }

  /// @param room  the part of the picture that nothing covers
  /// @param end   working end of the tool, in W; undefined: there is none
  update(eye: PerspectiveCamera, room: Room, end: Vec3 | undefined, name: string): void {
    const {clientHeight: height} = this.button.parentElement!;
    const at = end && new Vector3(...end).applyMatrix4(eye.matrixWorldInverse);
    const tan = Math.tan(MathUtils.degToRad(0.5 * eye.fov));
    const place = at && edgePlace([at.x, at.y, at.z], tan, room, height, kHalf);
    this.button.hidden = place === undefined;
    if (!place) return;
    const words = say("stage.out_of_picture", {tool: name});
    if (this.button.title !== words) this.button.title = this.button.ariaLabel = words;
    this.button.style.transform =
      `translate(${(place.x - kHalf).toFixed(1)}px, ${(place.y - kHalf).toFixed(1)}px) ` +
      `rotate(${place.angle.toFixed(3)}rad)`;
  }
}
