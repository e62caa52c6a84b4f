import type {SceneModel} from "../model/bundle";
import {type FetchedScene, fetchScene} from "../protocol/scene_fetch";

const kRetryMs = 1000;

export interface SceneStoreHost {
  headers(): Record<string, string>;
  isWanted(scene: string): boolean; // it is the one that is shown
  loading(is: boolean): void;
  /// The one that is shown.
  /// @param anew  it is not what was there before
  loaded(anew: boolean): void;
  /// @param whileSo  whether it still is wanted, and not there
  failed(reason: string, whileSo: () => boolean): void;
}

/// The scenes that have been fetched.
export class SceneStore {
  private readonly fetched = new Map<string, FetchedScene>();
  private loading = ""; // the scene
  private loadAgain = false;

  constructor(private readonly host: SceneStoreHost) {}

  model(scene: string): SceneModel | undefined {
    return this.fetched.get(scene)?.model;
  }

  async load(name: string): Promise<void> {
    const {host} = this;
    if (this.loading === name) {
      this.loadAgain = true; // it may have changed since it was asked for
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
      // Another scene may have been entered meanwhile: then the rest is its load's.
      if (this.loading === name) {
        this.loading = "";
        host.loading(false);
        if (this.loadAgain) void this.load(name);
      }
    }
  }
}
