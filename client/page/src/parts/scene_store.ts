import {say} from "../messages/say";
import {readBundle, type SceneModel} from "../model/bundle";

const kRetryMs = 1000;

/// A scene, with the ETag of the bytes that it was read from.
interface FetchedScene {
  readonly tag: string;
  readonly model: SceneModel;
}

/// Fetches the scene's bundle over HTTP; the browser caches it and revalidates by its ETag.
/// @param headers  with the token, if there is one
/// @param have     what the page already has; returned if nothing has changed
/// Throws an error whose message is for the reader.
async function fetchScene(
  name: string,
  headers: Record<string, string>,
  have?: FetchedScene,
): Promise<FetchedScene> {
  const path = `scene/${encodeURIComponent(name)}.bundle`;
  const response = await fetch(path, {cache: "no-cache", headers});
  if (response.status === 404) {
    throw new Error(say("scene.not_yet", {scene: name}));
  }
  if (!response.ok) {
    const status = String(response.status);
    throw new Error(say("scene.not_fetched", {scene: name, status}));
  }
  const tag = response.headers.get("ETag") ?? "";
  if (have && tag !== "" && tag === have.tag) {
    await response.body?.cancel();
    return have;
  }
  return {tag, model: readBundle(new Uint8Array(await response.arrayBuffer()))};
}

export interface SceneStoreHost {
  headers(): Record<string, string>;
  isWanted(scene: string): boolean; // whether it is the shown scene
  loading(is: boolean): void;
  /// The shown scene is there.
  /// @param anew  it differs from the former one
  loaded(anew: boolean): void;
  /// @param whileSo  returns whether it is still wanted and missing
  failed(reason: string, whileSo: () => boolean): void;
}

/// The scenes that have been fetched.
export class SceneStore {
  private readonly fetched = new Map<string, FetchedScene>();
  private loading = ""; // name of the scene
  private loadAgain = false;

  constructor(private readonly host: SceneStoreHost) {}

  model(scene: string): SceneModel | undefined {
    return this.fetched.get(scene)?.model;
  }

  async load(name: string): Promise<void> {
    const {host} = this;
    if (this.loading === name) {
      this.loadAgain = true; // it may have changed since it was requested
      return;
    }
    this.loading = name;
    this.loadAgain = false;
    host.loading(true);
    try {
      const have = this.fetched.get(name);
      const scene = await fetchScene(name, host.headers(), have);
      this.fetched.set(name, scene);
      if (host.isWanted(name)) host.loaded(scene !== have);
    } catch (error) {
      if (!host.isWanted(name)) return;
      const isMissing = (): boolean => host.isWanted(name) && !this.fetched.has(name);
      host.failed(error instanceof Error ? error.message : String(error), isMissing);
      window.setTimeout(() => {
        if (isMissing()) void this.load(name);
      }, kRetryMs);
    } finally {
      // Another scene may have been chosen meanwhile, whose own load then does the rest.
      if (this.loading === name) {
        this.loading = "";
        host.loading(false);
        if (this.loadAgain) void this.load(name);
      }
    }
  }
}
