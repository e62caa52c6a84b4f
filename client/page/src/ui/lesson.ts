import {say, sayList} from "../messages/say";
import type {SceneGoal} from "../protocol/messages";
import {rememberInAddress} from "./address";
import {element, onPress, setText} from "./elements";

/// The two views: a student needs force, touched objects and a goal; a teacher sees everything and
/// sets the goal.  The view is stored in the address, so links pass it on; the goal belongs to the
/// scene, and the gateway tells it to everybody.
export class Lesson {
  private readonly button = onPress("audience", () => this.switchAudience());
  private readonly goal = element("goal", HTMLParagraphElement);
  private readonly section = element("goal-section", HTMLElement);
  private readonly title = element("goal-title", HTMLHeadingElement);
  private readonly text = element("goal-text", HTMLInputElement);
  private readonly limit = element("goal-limit", HTMLInputElement);
  private readonly asked = new URLSearchParams(location.search).get("view");
  private isStudents = false;
  private scene = "";
  /// The goal's force limit; undefined: it has none.
  limitN: number | undefined;

  constructor(
    private readonly audienceChanged: (student: boolean) => void,
    private readonly set: (goal: {scene: string; text: string; limit_N: number}) => void,
  ) {
    this.setStudent(this.asked === "student");
    for (const input of [this.text, this.limit]) {
      input.addEventListener("change", () => this.goalSet());
    }
  }

  switchAudience(): void {
    const student = !document.body.classList.contains("student");
    this.setStudent(student);
    rememberInAddress("view", student ? "student" : this.isStudents ? "all" : "");
  }

  /// The page is a student's of a course, for whom the student's view is the default.
  greetStudent(): void {
    if (this.isStudents) return;
    this.isStudents = true;
    if (this.asked === null) this.setStudent(true);
  }

  /// Sets whether this page may set a goal.
  allow(may: boolean): void {
    this.section.hidden = !may;
  }

  /// @param goal  of that scene; undefined: it has none
  showGoal(scene: string, goal: SceneGoal | undefined): void {
    const another = scene !== this.scene;
    this.scene = scene;
    setText(this.title, () => say(scene === "" ? "goal.title" : "goal.title_of", {scene}));
    const text = goal?.text ?? "";
    this.limitN = goal && goal.limitN > 0 ? goal.limitN : undefined;
    const limit = this.limitN?.toString() ?? "";
    // Text that somebody is typing is kept.
    if (another || document.activeElement !== this.text) this.text.value = text;
    if (another || document.activeElement !== this.limit) this.limit.value = limit;
    const limitN = this.limitN;
    this.goal.hidden = text === "" && limitN === undefined;
    setText(this.goal, () => {
      const atMost = limitN === undefined ? "" : say("goal.at_most", {limit: limitN});
      return say("goal.is", {goal: sayList("list.separator", [text, atMost])});
    });
  }

  private setStudent(student: boolean): void {
    document.body.classList.toggle("student", student);
    this.button.setAttribute("aria-pressed", String(student));
    this.audienceChanged(student);
  }

  private goalSet(): void {
    const limit = Number.parseFloat(this.limit.value);
    const limit_N = limit > 0 ? limit : 0;
    this.set({scene: this.scene, text: this.text.value.trim(), limit_N});
  }
}
