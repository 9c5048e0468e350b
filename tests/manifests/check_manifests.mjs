// Checks Kubernetes manifests: node check_manifests.mjs MANIFESTS.yaml FOLDER
// The models and the validators of the npm package kubernetes-models are made of Kubernetes' own published schemas. The validators judge
// values. They let unknown fields pass, so the compiler of TypeScript judges the same documents by the models' types, in FOLDER.
import {execFileSync} from "node:child_process";
import {createRequire} from "node:module";
import fs from "node:fs";
import path from "node:path";
import YAML from "yaml";

const require = createRequire(import.meta.url);
const [file, folder] = process.argv.slice(2);
const wrong = [];
const documents = YAML.parseAllDocuments(fs.readFileSync(file, "utf8")).map((document) => {
  if (document.errors.length) wrong.push(...document.errors.map((error) => error.message));
  return document.toJS();
}).filter(Boolean);
// kustomize breaks the lines of base64, which Kubernetes allows and its schema does not.
for (const {kind, data} of documents)
  if (kind === "Secret") for (const key of Object.keys(data)) data[key] = data[key].replace(/\s/g, "");
const name = (document) => `${document.kind} ${document.metadata?.name}`;

// Each document, as a value of its model.
const modules = documents.map((document) => `kubernetes-models/${document.apiVersion}/${document.kind}`);
documents.forEach((document, i) => {
  try {
    const Model = require(modules[i])[document.kind];
    new Model(document).validate();
  } catch (error) {
    wrong.push(`${name(document)}: ${error.message}`);
  }
});
const program = documents.map((document, i) =>
  `import {I${document.kind} as Model${i}} from "${modules[i]}";\nexport const document${i}: Model${i} = ${JSON.stringify(document, null, 1)};\n`).join("");
fs.writeFileSync(path.join(folder, "documents.ts"), program);
try {
  execFileSync(process.execPath, [require.resolve("typescript/lib/tsc.js"), "--noEmit", "--strict", "--skipLibCheck", "--target", "es2022",
    "--module", "node16", "--moduleResolution", "node16", "documents.ts"], {cwd: folder, encoding: "utf8"});
} catch (error) {
  wrong.push(error.stdout || error.message);
}

// A schema cannot say these.
const all = (kind) => documents.filter((document) => document.kind === kind);
const pods = documents.filter((document) => document.spec?.template?.spec).map((document) => [name(document), document.spec.template.spec]);
const secrets = new Map(all("Secret").map((secret) => [secret.metadata.name, Object.keys(secret.data)]));
for (const [whose, pod] of pods) {
  for (const volume of pod.volumes ?? []) {
    if (!volume.secret) continue;
    const keys = secrets.get(volume.secret.secretName);
    if (!keys) wrong.push(`${whose}: there is no secret ${volume.secret.secretName}`);
    for (const item of keys ? volume.secret.items ?? [] : [])
      if (!keys.includes(item.key)) wrong.push(`${whose}: secret ${volume.secret.secretName} has no ${item.key}`);
  }
  for (const container of [...pod.initContainers ?? [], ...pod.containers])
    for (const mount of container.volumeMounts ?? []) {
      const volumes = [...pod.volumes ?? [], ...all("StatefulSet").flatMap((set) => set.spec.volumeClaimTemplates ?? []).map((claim) => claim.metadata)];
      if (!volumes.some((volume) => volume.name === mount.name)) wrong.push(`${whose}: there is no volume ${mount.name}`);
    }
}
// Whole cores for itself: only a pod that is Guaranteed gets them.
for (const [whose, pod] of pods.filter(([whose]) => whose.startsWith("DaemonSet")))
  for (const {name: container, resources: {requests, limits}} of [...pod.initContainers ?? [], ...pod.containers]) {
    if (JSON.stringify(requests) !== JSON.stringify(limits)) wrong.push(`${whose}: ${container}: requests and limits differ, so the pod is not Guaranteed`);
    if (!/^\d+$/.test(requests.cpu)) wrong.push(`${whose}: ${container}: ${requests.cpu} is no whole number of cores`);
  }
for (const selector of all("Service").map((service) => service.spec.selector))
  if (!documents.some((document) => Object.entries(selector).every(([key, value]) => document.spec?.template?.metadata.labels[key] === value)))
    wrong.push(`a service selects no pod: ${JSON.stringify(selector)}`);

for (const line of wrong) console.error(line);
console.log(`${documents.length} documents, ${wrong.length} wrong`);
process.exit(wrong.length || documents.length < 8 ? 1 : 0);
