import {type Key, say} from "../messages/say";
import {namesIn} from "../model/name_table";
import type {MadePerson, Person, Role} from "../protocol/class_messages";
import {make, option, press, setText, sure} from "./elements";
import {qrSvg} from "./qr";

export interface PeopleWishes {
  make(names: string[], role: Role): void;
  rename(person: number, name: string): void;
  renew(person: number): void;
  withdraw(person: number): void;
}

const kRoles = {
  drive: "class.drive",
  watch: "class.watch_only",
  operate: "class.operate",
} as const satisfies Record<Role, Key>;
const roleWord = (role: Role): string => say(kRoles[role]);
const isLocal = (host: string): boolean => /^(localhost|127\.|\[::1\])/.test(host);

/// Returns the link by which a person opens this page; browsers never send its fragment.
function linkOf(token: string): string {
  const url = new URL(".", location.href);
  url.hash = new URLSearchParams({token}).toString();
  return url.href;
}

/// The people of the class: adds, renames and withdraws them, and hands out their links.
export class ClassPeople {
  readonly body = make("div.class-people");
  private readonly names = make("textarea", {
    ...{id: "class-names", rows: 6, sayPlaceholder: "class.names_hint", spellcheck: false},
  });
  private readonly found = make("p.found", {role: "status", hidden: true});
  private readonly role = make("select", {id: "class-role"});
  private readonly links = make("section.links", {hidden: true});
  private readonly cards = make("ul.link-cards");
  private readonly list = make("ul.roster");
  private listed = "";

  constructor(private readonly wish: PeopleWishes) {
    const roles = Object.keys(kRoles) as Role[];
    this.role.append(...roles.map((role) => option(() => roleWord(role), role)));
    const add = make(
      "form.add",
      {
        onsubmit: (event) => {
          event.preventDefault();
          this.make();
        },
      },
      make("h3", {say: "class.add_title"}),
      make("label", {htmlFor: this.names.id, say: "class.names"}),
      this.names,
      this.found,
      make("label", {htmlFor: this.role.id}, () => `${say("class.role")} `, this.role),
      make("button.primary", {type: "submit", say: "class.make"}),
    );
    this.links.append(
      make("h3", {say: "class.links"}),
      make("p.quiet", {say: "class.links_once"}),
      make("p", {
        ...{className: "warn", say: "class.links_local"},
        hidden: !isLocal(location.hostname),
      }),
      press("class.print", () => print()),
      this.cards,
    );
    const roster = make("section", make("h3", {say: "class.in_class"}), this.list);
    this.body.append(make("div.left", add, roster), this.links);
  }

  /// Names found in a table are shown first: which column is the family's may be a guess.
  private make(): void {
    const {names, fromTable} = namesIn(this.names.value);
    this.found.hidden = !fromTable;
    if (fromTable) {
      this.names.value = names.join("\n");
      setText(this.found, () => say("class.from_table", {count: names.length}));
    } else if (names.length > 0) this.wish.make([...names], this.role.value as Role);
    else this.names.focus();
  }

  /// Shows the links just made by the gateway; earlier ones are removed.
  /// @param left  names whose links are still to be made
  handOut(made: readonly MadePerson[], left: readonly string[] = []): void {
    this.names.value = left.join("\n");
    this.cards.replaceChildren(...made.map((one) => this.card(one)));
    this.links.hidden = false;
    this.links.scrollIntoView({block: "nearest"});
  }
  /// The dialog was closed: its links are removed, so that nobody sees them later.
  forget(): void {
    this.links.hidden = true;
    this.cards.replaceChildren();
  }

  show(people: readonly Person[]): void {
    const now = JSON.stringify(people.map(({person, name, role}) => [person, name, role]));
    if (now === this.listed) return; // unchanged: what somebody types stays
    this.listed = now;
    this.list.replaceChildren(...people.map((person) => this.row(person)));
  }

  private card({name, token}: MadePerson): HTMLLIElement {
    const link = linkOf(token);
    const copy = press("class.copy", () => {
      void navigator.clipboard?.writeText(link).then(() => {
        setText(copy, () => say("class.copied"));
      });
    });
    const address = make("a", {href: link}, link);
    // Following it would give this page that person's token.
    address.addEventListener("click", (event) => event.preventDefault());
    return make(
      "li",
      make("b", name),
      qrSvg(link, () => say("class.qr", {name})),
      address,
      copy,
    );
  }

  private row({person, name, role}: Person): HTMLLIElement {
    const words = make("span.name", name);
    const beginToRename = (): void => {
      const input = make("input", {value: name, maxLength: 256, sayLabel: "class.rename"});
      const keep = make("button", {type: "submit", say: "class.keep"});
      const form = make("form.rename", input, keep);
      form.addEventListener("submit", (event) => {
        event.preventDefault();
        if (input.value.trim() !== "") this.wish.rename(person, input.value);
        form.replaceWith(words);
      });
      words.replaceWith(form);
      input.select();
    };
    const rename = press("class.rename", beginToRename, {
      sayTitle: "class.rename",
    });
    const renew = press("class.new_link", () => this.wish.renew(person), {
      title: () => say("class.new_link_title", {name}),
    });
    const withdraw = sure(
      () => say("class.withdraw"),
      () => say("class.sure"),
      () => this.wish.withdraw(person),
      {title: () => say("class.withdraw_title", {name})},
    );
    const choices = make("span.choices", rename, renew, withdraw);
    return make(
      "li",
      make(
        "p",
        words,
        " ",
        make("span.quiet", () => roleWord(role)),
      ),
      choices,
    );
  }
}
