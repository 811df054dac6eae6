// Renders with sunfleck, as `sunfleck farm --profile flamenco` asks for. For Flamenco 3.5 and later: workers need the command `exec`,
// and the Manager's variables {sunfleck} and {sunfleck-tools}, the paths of the two programs.

const JOB_TYPE = {
    label: "Sunfleck",
    description: "Falling leaves: frames in chunks, validated, and rendered again where need be",
    settings: [
        { key: "input", type: "string", subtype: "file_path", required: true, description: "What is rendered" },
        { key: "frames", type: "string", required: true, description: "Frames, such as 1-48 or 1,3,5" },
        { key: "chunk_size", type: "int32", default: 8, propargs: { min: 1 }, description: "Frames that a task renders" },
        { key: "output", type: "string", subtype: "dir_path", required: true, description: "Where frames go" },
        { key: "bakes", type: "string", subtype: "dir_path", required: true, description: "Falls of leaves that are baked already" },
        { key: "steps", type: "string", required: true, visible: "web", description: "The command lines, as JSON" },
    ],
};

function compileJob(job) {
    let before = [];
    for (const step of JSON.parse(job.settings.steps)) {
        const chunks = step.is_chunked ? frameChunker(job.settings.frames, job.settings.chunk_size) : [job.settings.frames];
        const tasks = chunks.map((chunk) => authorTask(step, chunk, job.settings));
        for (const task of tasks) {
            before.forEach((other) => task.addDependency(other));
            job.addTask(task);
        }
        before = tasks;
    }
}

// A step for some frames, the settings in their places.
function authorTask(step, chunk, settings) {
    const said = { input: settings.input, frames: settings.frames, output: settings.output, bakes: settings.bakes, chunk };
    const args = step.args.map((arg) => arg.replace(/<(\w+)>/g, (mark, name) => (name in said ? said[name] : mark)));
    const task = author.Task(step.is_chunked ? `${step.name} ${chunk}` : step.name, "misc");
    task.addCommand(author.Command("exec", { exe: step.exe, args }));
    return task;
}
