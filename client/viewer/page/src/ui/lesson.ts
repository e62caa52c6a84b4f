import {element, setText} from "./elements";

/// Who looks: a student, who needs force, depth, what is touched and a goal, or a teacher, who sees
/// all and sets the goal.  View, goal and limit stand in the address, which hands them on.
export class Lesson {
  private readonly button = element("audience", HTMLButtonElement);
  private readonly goal = element("goal", HTMLParagraphElement);
  private readonly text = element("goal-text", HTMLInputElement);
  private readonly limit = element("goal-limit", HTMLInputElement);

  constructor(
    private readonly readout: HTMLElement,
    private readonly remember: (name: string, value: string) => void,
    private readonly audienceChanged: (student: boolean) => void,
  ) {
    const given = new URLSearchParams(location.search);
    this.text.value = given.get("goal") ?? "";
    this.limit.value = given.get("limit") ?? "";
    this.setStudent(given.get("view") === "student");
    this.button.addEventListener("click", () => this.switchAudience());
    this.text.addEventListener("input", () => this.goalChanged());
    this.limit.addEventListener("input", () => this.goalChanged());
    this.showGoal();
  }

  switchAudience(): void {
    const student = !document.body.classList.contains("student");
    this.setStudent(student);
    this.remember("view", student ? "student" : "");
  }

  show(forceN: number): void {
    this.readout.classList.toggle("over", forceN > this.limitN);
  }

  private get limitN(): number {
    const value = Number.parseFloat(this.limit.value);
    return value > 0 ? value : Infinity;
  }

  private setStudent(student: boolean): void {
    document.body.classList.toggle("student", student);
    this.button.setAttribute("aria-pressed", String(student));
    this.audienceChanged(student);
  }

  private goalChanged(): void {
    this.remember("goal", this.text.value.trim());
    this.remember("limit", Number.isFinite(this.limitN) ? this.limit.value : "");
    this.showGoal();
  }

  private showGoal(): void {
    const most = Number.isFinite(this.limitN) ? `at most ${this.limitN} N` : "";
    const words = [this.text.value.trim(), most].filter((part) => part !== "").join(", ");
    this.goal.hidden = words === "";
    setText(this.goal, words === "" ? "" : `Goal: ${words}`);
  }
}
