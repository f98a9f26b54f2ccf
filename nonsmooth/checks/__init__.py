"""What the public border asks: arrays and numbers, files, memory, parameters. Each refusal is one sentence."""
